//! Tests of programming by the node: its requests to the slot, answer by answer, and its reports to the
//! master.

use crate::bench::{Bench, IDENTITY};
use UpdateCode::{Aborted, Done, Flash, NotNow, Sequence};
use UpdateState::{Erasing, Idle, Marked, Receiving, Trial, Verifying};
use narx_core::bus::narmotion::update::{
    BLOCK, ImageVersion, UpdateAnswer, UpdateCode, UpdateRequest, UpdateState, UpdateStatus,
};
use narx_core::bus::narmotion::{FromDrive, ToDrive};
use narx_core::node::Action;
use narx_core::node::update::{Condition, PIECE, SlotReply, SlotTask, Slots};

const HARDWARE: u32 = 0x4E58_0002;
const RUNNING: ImageVersion = ImageVersion { major: 3, minor: 5, patch: 7, build: 99 };
const SLOTS: Slots = Slots {
    hardware: HARDWARE,
    room: 4096,
    page: 2048,
    running: RUNNING,
    condition: Condition::Settled(Done),
};
/// Bytes of the image: a hundred blocks, one page.
const LENGTH: u32 = 600;
const BLOCKS: u16 = 100;
/// Number of blocks that may wait to be written, and number of those that are written at once.
const WINDOW: u16 = 2 * PIECE_BLOCKS;
const PIECE_BLOCKS: u16 = (PIECE / BLOCK) as u16;
/// Ticks from the beginning until the slot is changed.
const SETTLED: u64 = 50;

/// A node with a scripted slot.
struct Drive {
    bench: Bench,
    now: u64,
}

impl Drive {
    fn new(condition: Condition) -> Self {
        let mut bench = Bench::new();
        bench.node.attach_update(&Slots { condition, ..SLOTS });
        let mut drive = Self { bench, now: 0 };
        drive.pass(0);
        drive
    }

    /// A drive that waits for blocks.
    fn receiving() -> Self {
        let mut drive = Self::new(SLOTS.condition);
        drive.ask(begin(LENGTH));
        drive.pass(SETTLED);
        assert_eq!(drive.serve(), [SlotTask::Clear, SlotTask::Erase { offset: 0 }]);
        drive
    }

    /// A drive that has received and written every block.
    fn complete() -> Self {
        let mut drive = Self::receiving();
        for block in 0..BLOCKS {
            drive.send(block);
            drive.serve();
        }
        drive
    }

    fn pass(&mut self, ticks: u64) {
        self.now += ticks;
        self.bench.node.poll(self.now);
    }

    /// Answers the requests to the slot until there are no more; returns them. A checksum that is read back
    /// is right.
    fn serve(&mut self) -> Vec<SlotTask> {
        std::iter::from_fn(|| {
            let request = self.bench.node.poll_update()?;
            let report =
                if let SlotTask::Sum { .. } = request { SlotReply::Sum(CRC) } else { SlotReply::Done };
            self.bench.node.handle_update(report);
            Some(request)
        })
        .collect()
    }

    /// Reports about the update since the last call.
    fn received(&mut self) -> Vec<UpdateStatus> {
        let status = |message| match message {
            FromDrive::Update(UpdateAnswer::Status(status)) => Some(status),
            _ => None,
        };
        self.bench.messages().into_iter().filter_map(status).collect()
    }

    fn ask(&mut self, request: UpdateRequest) -> (UpdateState, UpdateCode) {
        self.received();
        self.bench.send(ToDrive::Update(request));
        match self.received()[..] {
            [UpdateStatus { state, code, .. }] => (state, code),
            ref other => panic!("{request:?}: {other:?}"),
        }
    }

    /// Sends a block; returns the answers.
    fn send(&mut self, block: u16) -> Vec<UpdateStatus> {
        self.received();
        self.bench.send(ToDrive::Update(UpdateRequest::Data { block, data: [block as u8; BLOCK] }));
        self.received()
    }

    fn status(&mut self) -> UpdateStatus {
        self.received();
        self.bench.send(ToDrive::Update(UpdateRequest::Status));
        self.received()[0]
    }
}

/// Checksum that the slot reads back.
const CRC: u32 = 0x1234_5678;
const END: UpdateRequest = UpdateRequest::End { crc: CRC };

const fn begin(length: u32) -> UpdateRequest {
    UpdateRequest::Begin { length, hardware: HARDWARE }
}

const fn at(code: UpdateCode, window: u16, offset: u32) -> UpdateStatus {
    UpdateStatus { state: Receiving, code, window, offset }
}

/// Each gap gets one answer: one for each block would fill the bus.
#[test]
fn a_block_that_is_not_the_next_is_told_once() {
    let mut drive = Drive::receiving();
    assert_eq!((drive.send(0), drive.send(1)), (vec![], vec![]));
    assert_eq!(drive.send(3), [at(Sequence, WINDOW - 2, 12)]);
    assert_eq!((drive.send(4), drive.send(99)), (vec![], vec![]));
    // The missing block, then earlier ones: neither gets an answer.
    assert_eq!((drive.send(2), drive.send(1), drive.send(0)), (vec![], vec![], vec![]));
    assert_eq!(drive.send(4), [at(Sequence, WINDOW - 3, 18)], "another gap");
    assert_eq!(drive.bench.refused(), 0);
}

#[test]
fn a_block_without_room_waits_for_the_slot() {
    let mut drive = Drive::receiving();
    for block in 0..WINDOW {
        assert_eq!(drive.send(block), []);
    }
    let full = u32::from(WINDOW) * BLOCK as u32;
    assert_eq!(drive.send(WINDOW), [at(Sequence, 0, full)]);
    let Some(SlotTask::Write { offset: 0, data }) = drive.bench.node.poll_update() else {
        panic!("the first piece is due")
    };
    let written: Vec<u8> = (0..PIECE).map(|place| (place / BLOCK) as u8).collect();
    assert_eq!(data, written[..]);
    assert_eq!(drive.bench.node.poll_update(), None, "one request at a time");
    drive.bench.node.handle_update(SlotReply::Done);
    assert_eq!(drive.received(), [at(Done, PIECE_BLOCKS, full)], "there is room again");
    assert_eq!(drive.send(WINDOW), []);
    assert_eq!(drive.status(), at(Done, PIECE_BLOCKS - 1, full + BLOCK as u32));
}

#[test]
fn a_block_behind_the_end_is_none() {
    let mut drive = Drive::complete();
    assert_eq!(drive.send(BLOCKS), [at(Sequence, WINDOW, LENGTH)]);
    assert_eq!((drive.send(BLOCKS), drive.send(BLOCKS + 1)), (vec![], vec![]));
    assert_eq!(drive.serve(), [], "all that there is is written");
    assert_eq!(drive.ask(END), (Verifying, Done));
    assert_eq!(drive.serve().last(), Some(&SlotTask::Mark { length: LENGTH }));
}

/// The last pieces are written before anything is read back; the master gets no report of each of them.
#[test]
fn an_end_waits_for_what_is_not_written() {
    let mut drive = Drive::receiving();
    for block in 0..BLOCKS {
        drive.send(block);
        if block < BLOCKS - PIECE_BLOCKS {
            drive.serve();
        }
    }
    assert_eq!(drive.ask(END), (Verifying, Done));
    let requests = drive.serve();
    let [writes @ .., SlotTask::Sum { offset: 0, length: LENGTH }, SlotTask::Mark { length: LENGTH }] =
        &requests[..]
    else {
        panic!("{requests:?}")
    };
    let bytes: usize = writes
        .iter()
        .map(|request| match request {
            // Whole pieces, and the last one filled up to 32 bytes.
            SlotTask::Write { offset, data } => {
                assert_eq!((offset % PIECE as u32, data.len() % 32), (0, 0));
                data.len().min((LENGTH - offset) as usize)
            }
            other => panic!("{other:?}"),
        })
        .sum();
    assert!(writes.len() >= 2 && bytes > PIECE, "{bytes} bytes in {} pieces", writes.len());
    let told: Vec<_> = drive.received().iter().map(|status| (status.state, status.code)).collect();
    assert_eq!(told, [(Marked, Done)]);
}

/// A second beginning, because the answer was lost or the master has changed its mind, goes on or begins anew
/// as needed.
#[test]
fn a_second_beginning() {
    let mut erasing = Drive::new(SLOTS.condition);
    erasing.ask(begin(LENGTH));
    erasing.pass(SETTLED);
    assert_eq!(erasing.bench.node.poll_update(), Some(SlotTask::Clear));
    erasing.bench.node.handle_update(SlotReply::Done);
    assert_eq!(erasing.ask(begin(LENGTH)), (Erasing, Done));
    assert_eq!(erasing.bench.node.poll_update(), Some(SlotTask::Erase { offset: 0 }), "it goes on");
    erasing.bench.node.handle_update(SlotReply::Done);
    assert_eq!(erasing.ask(begin(LENGTH)), (Receiving, Done), "nothing has come yet");

    let mut begun = Drive::receiving();
    begun.send(0);
    for (mut drive, length) in
        [(Drive::receiving(), LENGTH + 1), (Drive::complete(), LENGTH), (begun, LENGTH)]
    {
        assert_eq!(drive.ask(begin(length)), (Erasing, Done));
        assert_eq!(drive.serve(), [], "not before a start that was on its way is seen");
        drive.pass(SETTLED);
        assert_eq!(drive.serve(), [SlotTask::Clear, SlotTask::Erase { offset: 0 }]);
        assert_eq!(drive.status(), at(Done, WINDOW, 0));
    }
    let mut verifying = Drive::complete();
    verifying.ask(END);
    assert_eq!(verifying.ask(begin(LENGTH)), (Verifying, NotNow));
}

#[test]
fn a_second_end_is_of_the_same_image() {
    let other = UpdateRequest::End { crc: !CRC };
    let mut drive = Drive::complete();
    assert_eq!(drive.ask(END), (Verifying, Done));
    assert_eq!((drive.ask(END), drive.ask(other)), ((Verifying, Done), (Verifying, NotNow)));
    drive.serve();
    assert_eq!((drive.ask(END), drive.ask(other)), ((Marked, Done), (Marked, NotNow)));
}

/// A mark that is being written cannot be aborted; one that is written can be removed.
#[test]
fn an_abort_comes_too_late_for_a_mark() {
    let mut drive = Drive::complete();
    drive.ask(END);
    assert_eq!(drive.bench.node.poll_update(), Some(SlotTask::Sum { offset: 0, length: LENGTH }));
    drive.bench.node.handle_update(SlotReply::Sum(CRC));
    assert_eq!(drive.bench.node.poll_update(), Some(SlotTask::Mark { length: LENGTH }));
    assert_eq!(drive.ask(UpdateRequest::Abort), (Verifying, NotNow));
    drive.bench.node.handle_update(SlotReply::Done);
    assert_eq!(drive.ask(UpdateRequest::Abort), (Marked, Done));
    assert_eq!(drive.serve(), [SlotTask::Clear]);
    assert_eq!(drive.ask(UpdateRequest::Status), (Idle, Aborted));
}

/// A slot that gives another answer than the requested one, or a wrong checksum, is not marked.
#[test]
fn what_cannot_be_read_back_is_not_marked() {
    for (report, code) in [
        (SlotReply::Done, Flash),
        (SlotReply::Failed(Flash), Flash),
        (SlotReply::Sum(!CRC), UpdateCode::Checksum),
    ] {
        let mut drive = Drive::complete();
        drive.ask(END);
        assert!(matches!(drive.bench.node.poll_update(), Some(SlotTask::Sum { .. })));
        drive.bench.node.handle_update(report);
        assert_eq!((drive.serve(), drive.ask(UpdateRequest::Status)), (vec![], (Idle, code)), "{report:?}");
    }
}

/// If the minute of a trial ends while the confirmation is written, the node waits for its result.
#[test]
fn a_confirmation_under_way_is_not_cut_off() {
    const MINUTE: u64 = 600_000;
    for (report, end, action) in [
        (SlotReply::Done, (Idle, Done), None),
        (SlotReply::Failed(Flash), (Trial, Done), Some(Action::Reboot)),
    ] {
        let mut drive = Drive::new(Condition::Trial);
        assert_eq!(drive.ask(UpdateRequest::Confirm), (Trial, Done));
        assert_eq!(drive.bench.node.poll_update(), Some(SlotTask::Confirm));
        let act = |drive: &mut Drive| {
            drive.pass(MINUTE);
            drive.received();
            drive.bench.node.poll_action()
        };
        assert_eq!(act(&mut drive), None, "{report:?}");
        drive.bench.node.handle_update(report);
        let told = if action.is_some() { Flash } else { Done };
        assert_eq!(drive.received().last().map(|status| status.code), Some(told));
        assert_eq!((drive.ask(UpdateRequest::Status), act(&mut drive)), (end, action), "{report:?}");
    }
}

/// The identity of the device is that of the running image; if that was not programmed over the bus, the
/// board's.
#[test]
fn the_running_image_is_the_devices_identity() {
    for (running, software, build) in
        [(RUNNING, 0x0305, 99), (ImageVersion::default(), IDENTITY.software_release, IDENTITY.build_number)]
    {
        let mut bench = Bench::new();
        bench.node.attach_update(&Slots { running, ..SLOTS });
        bench.send(ToDrive::RequestDeviceInfo);
        bench.send(ToDrive::RequestBuildInfo);
        bench.send(ToDrive::Update(UpdateRequest::Version));
        let [
            FromDrive::DeviceInfo { software: told, .. },
            FromDrive::BuildInfo { number, .. },
            FromDrive::Update(UpdateAnswer::Version(version)),
        ] = bench.messages()[..]
        else {
            panic!("one answer each")
        };
        assert_eq!((told, number, version), (software, build, running));
    }
}

#[test]
fn a_board_without_a_bootloader_is_not_programmed() {
    let mut bench = Bench::new();
    let before = bench.node.clone();
    for report in [SlotReply::Done, SlotReply::Sum(0), SlotReply::Failed(Flash)] {
        bench.node.handle_update(report);
    }
    assert_eq!((bench.node.poll_update(), &bench.node), (None, &before));
    for request in [UpdateRequest::Device, UpdateRequest::Version, begin(LENGTH), END, UpdateRequest::Confirm]
    {
        bench.send(ToDrive::Update(request));
    }
    assert_eq!((bench.messages(), bench.refused(), bench.node.poll_update()), (vec![], 5, None));
}
