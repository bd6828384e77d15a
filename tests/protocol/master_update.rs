//! Tests of programming by the master, against a drive with scripted answers: the frames that it sends, those
//! that it ignores, and the events that end an update.

use crate::download_bench::sent;
use crate::pair::said;
use UpdateCode::{Aborted, Done, Flash, NotNow, Sequence, Signature, TimedOut};
use UpdateState::{Erasing, Idle, Marked, Receiving, Trial, Verifying};
use narx_core::bus::narmotion::update::{
    ImageVersion, UpdateAnswer, UpdateCode, UpdateRequest, UpdateState, UpdateStatus,
};
use narx_core::bus::narmotion::{FromDrive, ToDrive};
use narx_core::master::{Config, Image, Master, NotTaken, PACE, UpdateError, UpdateProgress, UpdateStage};

const MS: u64 = 1000;
const HARDWARE: u32 = 0x4E58_0002;
const OLD: ImageVersion = ImageVersion { major: 1, minor: 2, patch: 3, build: 4 };
const NEW: ImageVersion = ImageVersion { minor: 3, ..OLD };
/// Four blocks, the last one of two bytes.
const BYTES: [u8; 20] = *b"twenty bytes of code";
const LENGTH: u32 = BYTES.len() as u32;
/// Number of blocks of the image for which the drive has room at once.
const WINDOW: u16 = 32;

fn image() -> Image {
    Image::new(HARDWARE, NEW, &BYTES)
}

const fn status(state: UpdateState, code: UpdateCode, window: u16, offset: u32) -> FromDrive {
    FromDrive::Update(UpdateAnswer::Status(UpdateStatus { state, code, window, offset }))
}

const fn is(state: UpdateState, code: UpdateCode) -> FromDrive {
    status(state, code, 0, 0)
}

const DEVICE: FromDrive = FromDrive::Update(UpdateAnswer::Device { hardware: HARDWARE, room: 4096 });

const fn runs(version: ImageVersion) -> FromDrive {
    FromDrive::Update(UpdateAnswer::Version(version))
}

/// Stage of an update, named by the message that was just sent and whose answer is awaited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum At {
    Device,
    Version,
    Begin,
    Erasing,
    Sending,
    End,
    Verifying,
    Reboot,
    Waiting,
    Checking,
    Confirm,
}

/// Answer that leads to each stage, and the message that is sent then.
fn course() -> Vec<(At, FromDrive, Option<ToDrive>)> {
    let update = |request| Some(ToDrive::Update(request));
    vec![
        (At::Version, DEVICE, update(UpdateRequest::Version)),
        (At::Begin, runs(OLD), update(UpdateRequest::Begin { length: LENGTH, hardware: HARDWARE })),
        (At::Erasing, is(Erasing, Done), None),
        (At::Sending, status(Receiving, Done, WINDOW, 0), None),
        (At::End, status(Receiving, Done, WINDOW, LENGTH), update(UpdateRequest::End { crc: image().crc })),
        (At::Verifying, is(Verifying, Done), None),
        (At::Reboot, is(Marked, Done), None),
        (At::Waiting, FromDrive::Reboot, None),
        (At::Checking, is(Trial, Done), update(UpdateRequest::Version)),
        (At::Confirm, runs(NEW), update(UpdateRequest::Confirm)),
    ]
}

struct Script {
    master: Master,
    now: u64,
}

impl Script {
    fn new() -> Self {
        Self { master: Master::new(Config { read_parameters: false, ..Config::default() }), now: 10 * MS }
    }

    /// A script up to this stage. After stages later than [`At::Reboot`] nothing is left to be sent; in that
    /// stage the restart has yet to be requested.
    fn at(end: At) -> Self {
        let mut script = Self::new();
        script.master.update(image()).unwrap();
        assert_eq!(script.sent(), [ToDrive::Update(UpdateRequest::Device)]);
        for (at, answer, expected) in course() {
            if at > end {
                break;
            }
            if at == At::End {
                assert_eq!(script.blocks(), [0, 1, 2, 3]);
            }
            script.receive(answer);
            if at != At::Reboot {
                assert_eq!(script.sent(), Vec::from_iter(expected), "{at:?}");
            } else if at < end {
                assert_eq!(script.sent(), [ToDrive::Reboot]);
            }
        }
        script
    }

    fn receive(&mut self, message: FromDrive) {
        self.master.handle_frame(&said(message), self.now);
    }

    fn sent(&mut self) -> Vec<ToDrive> {
        sent(&mut self.master, self.now)
    }

    /// Numbers of the blocks that are due.
    fn blocks(&mut self) -> Vec<u16> {
        let frames = std::iter::from_fn(|| self.master.poll_update_frame(self.now, &BYTES));
        frames
            .map(|frame| match ToDrive::decode(&frame).unwrap().1 {
                ToDrive::Update(UpdateRequest::Data { block, data }) => {
                    let mut expected = [0xFF; 6];
                    let bytes = BYTES.chunks(6).nth(block.into()).expect("a block of the image");
                    expected[..bytes.len()].copy_from_slice(bytes);
                    assert_eq!(data, expected, "block {block}");
                    block
                }
                other => panic!("{other:?}"),
            })
            .collect()
    }
}

#[test]
fn an_update_keeps_its_course() {
    let mut script = Script::at(At::Confirm);
    script.receive(is(Idle, Done));
    assert_eq!(script.master.poll_update(), Some(Ok(())));
    assert_eq!((script.sent(), script.master.poll_update()), (vec![], None));
}

#[test]
fn one_update_at_a_time_and_none_by_a_silent_master() {
    let mut silent = Master::new(Config { silent: true, ..Config::default() });
    assert_eq!(silent.update(image()), Err(NotTaken::Silent));
    assert_eq!((silent.update_progress(), silent.poll_update()), (None, None));

    let mut script = Script::at(At::Sending);
    assert_eq!(script.master.update(image()), Err(NotTaken::Full));
    assert_eq!(script.blocks(), [0, 1, 2, 3], "the one under way goes on");
    script.receive(is(Idle, TimedOut));
    assert_eq!(script.master.update(image()), Err(NotTaken::Full), "its end was not taken");
    assert_eq!(script.master.poll_update(), Some(Err(UpdateError::Refused(TimedOut))));
    assert_eq!(script.master.update(image()), Ok(()));
}

/// An abort takes effect at once, in any stage and also while the caller sleeps until the next message is
/// due.
#[test]
fn an_abort_is_told_at_once() {
    let mut idle = Script::new();
    let before = (idle.sent(), idle.master.next_poll(idle.now));
    idle.master.abort_update();
    assert_eq!(
        (idle.sent(), idle.master.next_poll(idle.now), idle.master.poll_update()),
        (before.0, before.1, None)
    );

    for at in [At::Device, At::Erasing, At::Sending, At::Verifying, At::Waiting, At::Confirm] {
        let mut script = Script::at(at);
        script.sent();
        script.master.abort_update();
        assert_eq!(script.master.next_poll(script.now), script.now, "{at:?}");
        assert_eq!(script.blocks(), [0_u16; 0], "{at:?}: nothing more of the image");
        assert_eq!(script.sent(), [ToDrive::Update(UpdateRequest::Abort)], "{at:?}");
        assert_eq!(script.master.poll_update(), Some(Err(UpdateError::Aborted)), "{at:?}");
        assert_eq!(script.sent(), [], "{at:?}");
    }
}

/// These answers of the drive end an update, each in its stage.
#[test]
fn what_ends_an_update() {
    use UpdateError::{Forgotten, Hardware, Older, OtherVersion, Refused, TooLong};
    let newer = ImageVersion { build: 5, ..NEW };
    let device = |hardware, room| FromDrive::Update(UpdateAnswer::Device { hardware, room });
    for (at, answer, error) in [
        (At::Device, device(1, 4096), Hardware { image: HARDWARE, drive: 1 }),
        (At::Device, device(HARDWARE, LENGTH - 1), TooLong { length: LENGTH, room: LENGTH - 1 }),
        (At::Version, runs(newer), Older { image: NEW, running: newer }),
        (At::Begin, is(Idle, NotNow), Refused(NotNow)),
        (At::Begin, is(Verifying, NotNow), Refused(NotNow)),
        (At::Begin, is(Trial, UpdateCode::Trial), Refused(UpdateCode::Trial)),
        (At::Erasing, is(Idle, Flash), Refused(Flash)),
        (At::Sending, is(Idle, TimedOut), Refused(TimedOut)),
        (At::Sending, is(Idle, Done), Forgotten),
        (At::Sending, is(Trial, Done), Refused(UpdateCode::Trial)),
        (At::End, is(Idle, Aborted), Refused(Aborted)),
        (At::Verifying, is(Idle, UpdateCode::Checksum), Refused(UpdateCode::Checksum)),
        (At::Waiting, is(Idle, Signature), Refused(Signature)),
        (At::Checking, runs(OLD), OtherVersion(OLD)),
        // The flash did not accept the confirmation.
        (At::Confirm, is(Trial, Flash), Refused(Flash)),
    ] {
        let mut script = Script::at(at);
        script.receive(answer);
        assert_eq!(script.master.poll_update(), Some(Err(error)), "{at:?}: {answer:?}");
        assert_eq!((script.sent(), script.blocks()), (vec![], vec![]), "{at:?}: {answer:?}");
    }
}

/// Answers that come late, twice, or for another master at the same address are ignored.
#[test]
fn what_does_not_belong_to_a_stage_is_passed_over() {
    for (at, answer) in [
        (At::Device, is(Trial, Done)),
        (At::Device, runs(NEW)),
        (At::Device, FromDrive::Reboot),
        (At::Version, DEVICE),
        (At::Version, is(Idle, Flash)),
        (At::Begin, runs(NEW)),
        // Result of the previous update.
        (At::Begin, is(Idle, Done)),
        (At::Begin, is(Marked, Done)),
        (At::Sending, FromDrive::Reboot),
        (At::Sending, is(Erasing, Done)),
        (At::End, status(Receiving, Done, WINDOW, 12)),
        (At::End, FromDrive::Reboot),
        (At::Verifying, status(Receiving, Sequence, WINDOW, 12)),
        (At::Waiting, FromDrive::Reboot),
        (At::Waiting, is(Marked, Done)),
        (At::Waiting, runs(OLD)),
        (At::Checking, is(Idle, Done)),
        (At::Checking, is(Trial, Done)),
        (At::Confirm, is(Trial, Done)),
        (At::Confirm, runs(NEW)),
        (At::Confirm, DEVICE),
    ] {
        let (mut script, mut other) = (Script::at(at), Script::at(at));
        script.receive(answer);
        assert_eq!(script.master.poll_update(), None, "{at:?}: {answer:?}");
        assert_eq!(script.master.update_progress(), other.master.update_progress(), "{at:?}: {answer:?}");
        // The update goes on as before.
        for _ in 0..20 {
            script.now += 50 * MS;
            other.now += 50 * MS;
            assert_eq!(script.sent(), other.sent(), "{at:?}: {answer:?}, at {} us", script.now);
            assert_eq!(script.blocks(), other.blocks(), "{at:?}: {answer:?}");
        }
    }
}

/// A drive that reports a restart before it was requested, because of another master, is not requested again:
/// that would bring the old image back.
#[test]
fn a_drive_that_restarts_by_itself_is_waited_for() {
    let mut script = Script::at(At::Reboot);
    script.receive(FromDrive::Reboot);
    assert_eq!(script.sent(), []);
    script.now += 200 * MS;
    assert_eq!(script.sent(), [ToDrive::Update(UpdateRequest::Status)]);
    script.receive(is(Trial, Done));
    assert_eq!(script.sent(), [ToDrive::Update(UpdateRequest::Version)]);
}

/// A lost request for a restart is repeated a second later, and not before.
#[test]
fn a_drive_that_has_not_restarted_is_asked_again() {
    let mut script = Script::at(At::Waiting);
    let asked = script.now;
    let again = loop {
        script.now += 50 * MS;
        script.receive(is(Marked, Done));
        if script.sent().contains(&ToDrive::Reboot) {
            break script.now - asked;
        }
        assert!(script.now < asked + 2000 * MS, "a second has passed");
    };
    assert_eq!(again, 1000 * MS);
}

/// A caller that looks when the erasing has already ended has been told of it: it begins with its request.
#[test]
fn erasing_begins_with_its_request() {
    let mut script = Script::at(At::Begin);
    let stage = |script: &Script| script.master.update_progress().unwrap().stage;
    assert_eq!(stage(&script), UpdateStage::Erasing);
    script.receive(status(Receiving, Done, WINDOW, 0));
    assert_eq!(stage(&script), UpdateStage::Sending);
}

/// If a part of the image is missing, the master goes on from the drive's position, in whatever stage it is
/// reported.
#[test]
fn what_is_missing_is_sent_again() {
    let gap = status(Receiving, Sequence, 2, 6);
    for at in [At::Sending, At::End] {
        let mut script = Script::at(at);
        script.blocks();
        script.receive(gap);
        script.now += 4 * PACE;
        assert_eq!(script.blocks(), [1, 2], "{at:?}: as far as there is room");
        let progress = UpdateProgress { stage: UpdateStage::Sending, done: 6, total: LENGTH };
        assert_eq!(script.master.update_progress(), Some(progress), "{at:?}");
        script.receive(status(Receiving, Done, WINDOW, 18));
        assert_eq!(script.blocks(), [3], "{at:?}: what is on its way is not sent twice");
        script.receive(status(Receiving, Done, WINDOW, LENGTH));
        assert_eq!(script.sent(), [ToDrive::Update(UpdateRequest::End { crc: image().crc })], "{at:?}");
    }
}

/// A caller that sleeps until the next poll is due sends the same messages at the same times as one that
/// always polls: a burst of blocks, then one after the other.
#[test]
fn polling_when_it_says_is_enough() {
    const END: u64 = 400 * MS;
    let bytes = [0xA5; 600];
    let course = |next: &dyn Fn(&Master, u64) -> u64| {
        let mut master = Master::new(Config { read_parameters: false, ..Config::default() });
        master.update(Image::new(HARDWARE, NEW, &bytes)).unwrap();
        let mut answers = [DEVICE, runs(OLD), is(Erasing, Done)].into_iter();
        let (mut messages, mut polls, mut now) = (Vec::new(), 0, 10 * MS);
        while now < END {
            let frames = std::iter::from_fn(|| master.poll_frame(now));
            let frames: Vec<_> = frames.map(|frame| ToDrive::decode(&frame).unwrap().1).collect();
            messages.extend(frames.iter().map(|message| (now, *message)));
            while let Some(block) = master.poll_update_frame(now, &bytes) {
                messages.push((now, ToDrive::decode(&block).unwrap().1));
            }
            // The drive answers at once; it has erased its slot when its status is requested.
            if frames.iter().any(|message| matches!(message, ToDrive::Update(_))) {
                let answer = answers.next().unwrap_or(status(Receiving, Done, 100, 0));
                master.handle_frame(&said(answer), now);
            }
            polls += 1;
            now = next(&master, now);
        }
        (messages, polls)
    };
    let (eager, _) = course(&|_, now| now + 100);
    let (lazy, polls) = course(&|master, now| {
        let next = master.next_poll(now);
        // Messages that follow an answer are due at once; no others are.
        if next > now { next } else { now + 100 }
    });
    assert_eq!(lazy, eager);
    let blocks: Vec<u64> = eager
        .iter()
        .filter(|(_, message)| matches!(message, ToDrive::Update(UpdateRequest::Data { .. })))
        .map(|(at, _)| *at)
        .collect();
    assert!(blocks.len() > 100 && blocks[8] == blocks[0] && blocks[10] - blocks[9] == PACE, "{blocks:?}");
    assert!(polls < 2 * blocks.len() + 20, "{polls} polls, {} blocks", blocks.len());
}

/// If the caller no longer has all bytes of the image, the missing ones are not sent; the drive determines
/// when it gives up.
#[test]
fn an_image_that_is_shorter_than_it_was_said_to_be() {
    let mut script = Script::at(At::Sending);
    assert!(script.master.poll_update_frame(script.now, &BYTES[..6]).is_some());
    assert!(script.master.poll_update_frame(script.now, &BYTES[..5]).is_none());
    assert_eq!(script.blocks(), [1, 2, 3]);
}
