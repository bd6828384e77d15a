//! The drive's side of programming: what it refuses and why, what it repairs, and what it leaves alone.

use crate::support::{Flash, HARDWARE, Hasty, MAP, NEW, OLD, board_with, receive, version};
use crate::wire::Drive;
use narx_boot::{Server, Slot};
use narx_core::bus::narmotion::MotorMode;
use narx_core::bus::narmotion::update::{UpdateAnswer, UpdateCode, UpdateRequest, UpdateState, UpdateStatus};
use narx_core::motor::{Event, State};
use narx_core::node::update::Condition;
use proptest::prelude::*;

const CRC: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

fn begin(length: usize) -> UpdateRequest {
    UpdateRequest::Begin { length: length as u32, hardware: HARDWARE }
}

fn end(image: &[u8]) -> UpdateRequest {
    UpdateRequest::End { crc: CRC.checksum(image) }
}

fn factory() -> Flash {
    board_with(&Hasty::image(OLD, 1000))
}

fn said(status: UpdateStatus) -> (UpdateState, UpdateCode) {
    (status.state, status.code)
}

#[test]
fn it_tells_what_it_takes() {
    let mut drive = Drive::new(factory());
    drive.tell(UpdateRequest::Device);
    drive.tell(UpdateRequest::Version);
    let device = UpdateAnswer::Device { hardware: HARDWARE, room: MAP.room() };
    assert_eq!(drive.received(), [device, UpdateAnswer::Version(OLD.into())]);
}

#[test]
fn an_image_is_received_and_marked() {
    let mut drive = Drive::new(factory());
    let image = Hasty::image(NEW, 1528);
    assert_eq!(said(drive.ask(begin(image.len()))), (UpdateState::Erasing, UpdateCode::Done));
    drive.send(&image);
    let status = drive.ask(UpdateRequest::Status);
    assert_eq!((status.state, status.offset), (UpdateState::Receiving, image.len() as u32));
    assert_eq!(said(drive.ask(end(&image))), (UpdateState::Verifying, UpdateCode::Done));
    drive.run(20);
    assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Marked, UpdateCode::Done));
    // Asked again, because the answer was lost.
    assert_eq!(said(drive.ask(end(&image))), (UpdateState::Marked, UpdateCode::Done));
    assert!(drive.is_marked());
    assert_eq!(drive.refused(), 0);
}

/// Requests that are refused before anything happens, with their codes; the drive is as it was.
#[test]
fn refusals_have_codes() {
    use UpdateCode::{Done, Hardware, Length, NotNow, Trial, WrongState};
    let room = MAP.room() as usize;
    let cases = [
        (State::Standby, UpdateRequest::Begin { length: 1000, hardware: HARDWARE + 1 }, Hardware),
        (State::Standby, begin(0), Length),
        (State::Standby, begin(519), Length),
        (State::Standby, begin(room + 1), Length),
        (State::Standby, begin(u32::MAX as usize), Length),
        (State::HallClosedLoop, begin(1000), WrongState),
        (State::Initialization, begin(1000), WrongState),
        (State::Standby, UpdateRequest::End { crc: 0 }, NotNow),
        (State::Standby, UpdateRequest::Abort, Done),
        (State::Standby, UpdateRequest::Confirm, Done),
    ];
    for (state, request, code) in cases {
        let mut drive = Drive::new(factory());
        drive.set_state(state);
        assert_eq!(said(drive.ask(request)), (UpdateState::Idle, code), "{request:?}");
        drive.run(30);
        assert_eq!(drive.server.slot().flash().steps(), 0, "{request:?}");
    }
    // The longest image there is room for, and a drive in Fault at standstill.
    let mut drive = Drive::new(factory());
    drive.set_state(State::Fault);
    assert_eq!(said(drive.ask(begin(room))), (UpdateState::Erasing, Done));
    // On trial the slot is not free.
    let mut drive = on_trial();
    assert_eq!(said(drive.ask(begin(1000))), (UpdateState::Trial, Trial));
    assert_eq!(said(drive.ask(UpdateRequest::Abort)), (UpdateState::Trial, NotNow));
}

/// Images that are found to be wrong at the end of the transfer; nothing is marked.
#[test]
fn images_that_are_not_marked() {
    let good = Hasty::image(NEW, 1000);
    let mut other_board = good.clone();
    other_board[15] ^= 1;
    let cases = [
        ("another CRC", good.clone(), 1, UpdateCode::Checksum),
        ("no image", vec![0; 1000], 0, UpdateCode::NoImage),
        ("another board's", other_board, 0, UpdateCode::Hardware),
        ("a part", good[..800].to_vec(), 0, UpdateCode::Length),
        ("older", Hasty::image(version(1, 2, 3, 3), 1000), 0, UpdateCode::Older),
    ];
    for (what, image, wrong, code) in cases {
        let mut drive = Drive::new(factory());
        drive.send(&image);
        drive.tell(UpdateRequest::End { crc: CRC.checksum(&image) ^ wrong });
        drive.run(30);
        assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Idle, code), "{what}");
        assert!(!drive.is_marked(), "{what}");
    }
}

#[test]
fn an_end_before_the_end_tells_what_is_missing() {
    let mut drive = Drive::new(factory());
    let image = Hasty::image(NEW, 1000);
    drive.send(&image[..600]);
    drive.tell(begin(image.len()));
    drive.run(20);
    let status = drive.ask(end(&image));
    assert_eq!((said(status), status.offset), ((UpdateState::Receiving, UpdateCode::Sequence), 0));
}

/// A motor that is asked for does not start beside a flash that is written; what stops it is received.
#[test]
fn no_start_while_it_receives() {
    let mut drive = Drive::new(factory());
    drive.tell(begin(1000));
    drive.run(20);
    while drive.node.poll_event().is_some() {}
    for mode in [MotorMode::Drive, MotorMode::Reverse] {
        drive.request(mode);
        assert_eq!(drive.node.poll_event(), None, "{mode:?}");
    }
    assert_eq!(drive.refused(), 2);
    for mode in [MotorMode::Standby, MotorMode::Fault] {
        drive.request(mode);
        assert!(matches!(drive.node.poll_event(), Some(Event::Command(_))), "{mode:?}");
    }
    // Behind it a start is a start again.
    drive.tell(UpdateRequest::Abort);
    drive.request(MotorMode::Drive);
    assert!(matches!(drive.node.poll_event(), Some(Event::Command(_))));
}

/// A start that was on its way when the update began: the flash is let alone.
#[test]
fn a_motor_that_starts_ends_the_update() {
    let mut drive = Drive::new(factory());
    drive.tell(begin(1000));
    drive.run(2);
    drive.set_state(State::RotorLock);
    drive.run(20);
    assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Idle, UpdateCode::WrongState));
    assert_eq!(drive.server.slot().flash().steps(), 0);
}

#[test]
fn an_update_without_blocks_is_over_after_ten_seconds() {
    let mut drive = Drive::new(factory());
    drive.tell(begin(1000));
    drive.run(9_900);
    drive.tell(UpdateRequest::Data { block: 0, data: [1; 6] });
    drive.run(9_900);
    assert_eq!(drive.ask(UpdateRequest::Status).state, UpdateState::Receiving);
    drive.run(200);
    assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Idle, UpdateCode::TimedOut));
}

/// Ended by the master at any moment, with a request to the flash under way or not, and begun anew at once.
#[test]
fn an_update_can_be_aborted_and_begun_anew() {
    let image = Hasty::image(NEW, 1000);
    for moment in 0..60 {
        let mut drive = Drive::new(factory());
        drive.tell(begin(image.len()));
        drive.run(moment);
        let request = drive.node.poll_update();
        assert_eq!(
            said(drive.ask(UpdateRequest::Abort)),
            (UpdateState::Idle, UpdateCode::Aborted),
            "{moment}"
        );
        drive.tell(begin(image.len()));
        if let Some(request) = request {
            let report = drive.server.execute(&request);
            drive.node.handle_update(report);
        }
        drive.send(&image);
        drive.tell(end(&image));
        drive.run(20);
        assert!(drive.is_marked(), "{moment}");
    }
}

#[test]
fn a_mark_can_be_taken_back() {
    let mut drive = Drive::new(factory());
    let image = Hasty::image(NEW, 1000);
    drive.send(&image);
    drive.tell(end(&image));
    drive.run(20);
    assert!(drive.is_marked());
    drive.tell(UpdateRequest::Abort);
    drive.run(3);
    assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Idle, UpdateCode::Aborted));
    assert!(!drive.is_marked());
}

/// An application that starts anew without a look of the bootloader's finds the mark.
#[test]
fn a_mark_outlives_a_restart_without_the_bootloader() {
    let mut flash = factory();
    receive(&mut flash, &Hasty::image(NEW, 1000)).unwrap();
    let mut server = Server::new(Slot::new(flash, MAP, HARDWARE).unwrap());
    assert_eq!(format!("{server:?}"), format!("{:?}", server.slot()));
    let slots = server.slots().unwrap();
    assert_eq!((slots.condition, slots.running), (Condition::Marked, OLD.into()));
}

fn on_trial() -> Drive {
    let mut drive = Drive::new(factory());
    let image = Hasty::image(NEW, 1000);
    drive.send(&image);
    drive.tell(end(&image));
    drive.run(20);
    drive.reboot();
    assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Trial, UpdateCode::Done));
    drive
}

/// Nothing turns under an image that nobody has confirmed, and after a minute it gives up by itself.
#[test]
fn a_trial_ends_by_itself() {
    let mut drive = on_trial();
    drive.request(MotorMode::Drive);
    while let Some(event) = drive.node.poll_event() {
        assert!(!matches!(event, Event::Command(_)));
    }
    drive.run(59_900);
    let mut restarts = (0..200).map(|_| {
        // A drive restarts when its bus has taken what it had to say.
        drive.received();
        drive.pass()
    });
    assert!(restarts.any(|restarts| restarts));
    drive.reboot();
    drive.tell(UpdateRequest::Version);
    assert_eq!(drive.received(), [UpdateAnswer::Version(OLD.into())]);
    assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Idle, UpdateCode::Reverted));
}

#[test]
fn a_confirmed_image_stays() {
    let mut drive = on_trial();
    drive.tell(UpdateRequest::Confirm);
    drive.run(3);
    assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Idle, UpdateCode::Done));
    drive.run(70_000);
    drive.reboot();
    drive.tell(UpdateRequest::Version);
    assert_eq!(drive.received(), [UpdateAnswer::Version(NEW.into())]);
    drive.request(MotorMode::Drive);
    let mut events = std::iter::from_fn(|| drive.node.poll_event());
    assert!(events.any(|event| matches!(event, Event::Command(_))));
}

/// A flash that fails ends the update; a shell that does not answer leaves the drive what it is.
#[test]
fn a_flash_that_fails_is_told() {
    let mut drive = Drive::new(factory());
    drive.tell(begin(1000));
    drive.server.slot().flash().cut_after(1, narx_sim::flash::Tear::Nothing);
    drive.run(30);
    assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Idle, UpdateCode::Flash));
    let mut drive = Drive::new(factory());
    drive.is_stuck = true;
    drive.tell(begin(1000));
    drive.run(100);
    assert_eq!(said(drive.ask(UpdateRequest::Status)), (UpdateState::Erasing, UpdateCode::Done));
}

proptest! {
    /// Whatever a master sends, in any order: no panic, no mark without an image whose CRC it has, and a
    /// window that holds.
    #[test]
    fn any_requests(steps in prop::collection::vec((0..9_u8, any::<u32>(), 0..4_u64), 1..60)) {
        let mut drive = Drive::new(factory());
        let image = Hasty::image(NEW, 1000);
        for (kind, value, wait) in steps {
            drive.tell(match kind {
                0 => begin(image.len()),
                1 => UpdateRequest::Begin { length: value, hardware: HARDWARE },
                2 => UpdateRequest::End { crc: value },
                3 => UpdateRequest::Abort,
                4 => UpdateRequest::Confirm,
                5 => UpdateRequest::Status,
                _ => UpdateRequest::Data { block: value as u16 % 40, data: [value as u8; 6] },
            });
            drive.run(wait * 5);
            for answer in drive.received() {
                if let UpdateAnswer::Status(status) = answer {
                    prop_assert!(status.window <= 32);
                }
            }
        }
        prop_assert!(!drive.is_marked());
    }
}
