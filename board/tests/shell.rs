//! The shell on a board of paper: who is served when, and who must have worked before the watchdog is fed.

use narx_board::shell::{Background, Control, INPUTS_MS, Progress};
use narx_board::side::{BackgroundSide, TickSide};
use narx_core::bus::narmotion::{FromDrive, MotorMode, ParameterStatus, RequestWord, ToDrive, XmlCommand};
use narx_core::bus::{BusState, ErrorState, Frame};
use narx_core::device::Queues;
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::{Board, PwmCommand, Samples, Step};
#[cfg(feature = "update")]
use narx_core::node::update;
use narx_core::node::{Identity, Node, Outputs, ResetCause, SelfTests, SlowInputs};
use narx_core::storage::{FlashReply, FlashTask, Mailbox, Storage};
use narx_sim::flash::{Flash, KBYTE_512, finish};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::pin::pin;
use std::rc::Rc;
use std::task::{Context, Waker};

/// State of the board, and record of what has happened on it.
#[derive(Default)]
struct Paper {
    now: u64,
    clock_stopped: bool,
    arriving: VecDeque<Frame>,
    sent: Vec<Frame>,
    bus_full: bool,
    /// Frames in the controller: the bus takes one in a pass.
    waiting: usize,
    bus: BusState,
    discarded: u64,
    inputs_read: u64,
    fed: u64,
    reboots: u64,
    commands: Vec<PwmCommand>,
    failed: SelfTests,
    rests: Vec<bool>,
}

#[derive(Clone, Default)]
struct Side(Rc<RefCell<Paper>>);

impl TickSide for Side {
    fn samples(&mut self) -> Option<Samples> {
        // 24 V and no current.
        let now = self.0.borrow().now;
        Some(Samples { tick: now, bus_voltage: 1_229, bus_current: 2_048, hall: 0b101, ..Samples::default() })
    }

    fn apply(&mut self, command: &PwmCommand) {
        self.0.borrow_mut().commands.push(*command);
    }
}

impl BackgroundSide for Side {
    fn now(&self) -> u64 {
        self.0.borrow().now
    }

    fn wait(&mut self) {
        let mut paper = self.0.borrow_mut();
        paper.now += u64::from(!paper.clock_stopped);
        paper.waiting = paper.waiting.saturating_sub(1);
    }

    fn receive(&mut self) -> Option<Frame> {
        self.0.borrow_mut().arriving.pop_front()
    }

    fn is_ready_to_send(&self) -> bool {
        !self.0.borrow().bus_full
    }

    fn is_ready_for_bulk(&self) -> bool {
        self.0.borrow().waiting < 2
    }

    fn send(&mut self, frame: &Frame) {
        let mut paper = self.0.borrow_mut();
        paper.sent.push(*frame);
        paper.waiting += 1;
    }

    fn bus_state(&self) -> BusState {
        self.0.borrow().bus
    }

    fn discard_frames(&mut self) {
        self.0.borrow_mut().discarded += 1;
    }

    fn slow_inputs(&mut self) -> SlowInputs {
        self.0.borrow_mut().inputs_read += 1;
        SlowInputs::default()
    }

    fn apply(&mut self, _: Outputs) {}

    fn rest(&mut self, is_at_rest: bool) {
        let mut paper = self.0.borrow_mut();
        if paper.rests.last() != Some(&is_at_rest) {
            paper.rests.push(is_at_rest);
        }
    }

    fn self_test(&mut self) -> SelfTests {
        self.0.borrow().failed
    }

    #[cfg(feature = "update")]
    fn serve_update(&mut self, _: &update::SlotTask) -> update::SlotReply {
        update::SlotReply::Done
    }

    fn feed_watchdog(&mut self) {
        self.0.borrow_mut().fed += 1;
    }

    fn reboot(&mut self) {
        self.0.borrow_mut().reboots += 1;
    }
}

/// Runs a device for `ticks` periods; `each` sees the board before each and says whether the control
/// interrupt comes.
fn run(ticks: u64, mut each: impl FnMut(u64, &mut Paper) -> bool) -> Side {
    let side = Side::default();
    let progress = Progress::new();
    let mut queues = Queues::new();
    let mut parameters = Parameters::new();
    parameters.set(number::HALL_ENABLE, 1).expect("a mode");
    let (tick, device) = queues.power_up(Identity::default(), Board::BENCH, parameters);
    let mut control = Control::new(tick, side.clone(), &progress);
    let mut background =
        Background::new(device, side.clone(), &progress).with_reset_cause(ResetCause::Watchdog);
    for number in 0..ticks {
        if each(number, &mut side.0.borrow_mut()) {
            control.interrupt();
        }
        background.pass();
    }
    side
}

fn request(mode: MotorMode) -> Frame {
    let addresses = Node::new(Identity::default(), Board::BENCH).addresses();
    ToDrive::RequestWord(RequestWord { mode }).encode(addresses)
}

#[test]
fn every_part_is_served_and_the_watchdog_fed() {
    let side = run(10_000, |_, _| true);
    let paper = side.0.borrow();
    assert_eq!(paper.commands.len(), 10_000, "a command for every period");
    assert!(paper.commands.iter().all(|command| command.step == Step::Coast), "nobody asked for more");
    assert_eq!(paper.inputs_read, 1_000 / INPUTS_MS);
    assert!(paper.sent.len() > 20, "broadcasts: {}", paper.sent.len());
    assert_eq!(paper.fed, 10_000);
}

#[test]
fn without_control_interrupt_the_watchdog_is_not_fed() {
    let side = run(2_000, |tick, _| tick < 1_000);
    assert_eq!(side.0.borrow().fed, 1_000);
}

#[test]
fn when_the_background_sees_no_time_pass_the_watchdog_is_not_fed() {
    let side = run(2_000, |tick, paper| {
        paper.clock_stopped = tick >= 1_000;
        true
    });
    assert_eq!(side.0.borrow().fed, 1_000);
}

#[test]
fn a_bus_that_takes_nothing_and_one_that_floods_stop_neither_control_nor_watchdog() {
    let side = run(10_000, |_, paper| {
        paper.bus_full = true;
        paper.arriving.extend([request(MotorMode::Standby); 20]);
        true
    });
    let paper = side.0.borrow();
    assert!(paper.sent.is_empty());
    assert_eq!((paper.commands.len(), paper.fed), (10_000, 10_000));
}

#[test]
fn the_flash_is_served_between_passes() {
    let memory = vec![0xFF; 512 << 10].leak();
    let mut storage = Storage::new(Flash::new(KBYTE_512, memory, 0));
    assert_eq!(finish(storage.format(&Parameters::new())), Some(true));
    let Some(FlashReply::Opened(opened)) = finish(storage.execute(FlashTask::Open)) else { panic!("opened") };
    let (side, progress, mailbox) = (Side::default(), Progress::new(), Mailbox::new());
    let mut queues = Queues::new();
    let (tick, device) = queues.power_up(Identity::default(), Board::BENCH, opened.parameters.clone());
    let mut control = Control::new(tick, side.clone(), &progress);
    let mut background = Background::new(device, side.clone(), &progress).with_flash(&mailbox, &opened);
    let addresses = Node::new(Identity::default(), Board::BENCH).addresses();
    let mut task = pin!(mailbox.serve(&mut storage));
    for number in 0..7_000 {
        if number == 6_000 {
            let written = [(99, 1234), (256, 0), (256, 1)];
            let frames =
                written.map(|(number, value)| ToDrive::SetParameter { number, value }.encode(addresses));
            side.0.borrow_mut().arriving.extend(frames);
        }
        control.interrupt();
        background.pass();
        let _ = task.as_mut().poll(&mut Context::from_waker(Waker::noop()));
    }
    let paper = side.0.borrow();
    let stored = FromDrive::Parameter { number: 256, value: 1, status: ParameterStatus::Done };
    assert!(
        paper
            .sent
            .iter()
            .any(|frame| matches!(FromDrive::decode(frame), Ok((_, message)) if message == stored))
    );
    assert_eq!(paper.fed, 7_000);
}

#[test]
fn a_download_flows_as_fast_as_the_bus_and_fills_no_queue() {
    let addresses = Node::new(Identity::default(), Board::BENCH).addresses();
    let side = run(9_000, |tick, paper| {
        if tick == 7_000 {
            paper.sent.clear();
            paper.arriving.push_back(ToDrive::DownloadXml(XmlCommand::Start).encode(addresses));
        }
        // Two of the download, and a status and a fault word.
        assert!(paper.waiting <= 4, "{}", paper.waiting);
        true
    });
    let paper = side.0.borrow();
    let data = |frame: &&Frame| matches!(FromDrive::decode(frame), Ok((_, FromDrive::XmlData { .. })));
    let downloaded = paper.sent.iter().filter(data).count();
    assert!((1_980..=2_000).contains(&downloaded), "the bus takes one frame a pass: {downloaded}");
}

#[test]
fn a_reboot_is_done_once_and_its_acknowledgement_goes_first() {
    let addresses = Node::new(Identity::default(), Board::BENCH).addresses();
    let mut seen = None;
    let side = run(8_000, |tick, paper| {
        if tick == 7_000 {
            paper.sent.clear();
            paper.arriving.push_back(ToDrive::Reboot.encode(addresses));
        }
        if paper.reboots == 1 && seen.is_none() {
            seen = Some(paper.sent.clone());
        }
        true
    });
    assert_eq!(side.0.borrow().reboots, 1);
    let before = seen.unwrap();
    assert!(
        before.iter().any(|frame| matches!(FromDrive::decode(frame), Ok((_, FromDrive::Reboot)))),
        "{before:?}"
    );
}

#[test]
fn off_the_bus_nothing_is_sent_and_control_goes_on() {
    let off = BusState { error: ErrorState::BusOff, transmit_errors: 256, receive_errors: 0 };
    let side = run(6_000, |tick, paper| {
        if tick == 2_000 {
            paper.bus = off;
            paper.sent.clear();
        }
        if tick == 4_000 {
            assert!(paper.sent.is_empty(), "{:?}", paper.sent);
            paper.bus = BusState::default();
        }
        true
    });
    let paper = side.0.borrow();
    assert_eq!(paper.discarded, 2_000, "what the controller holds is taken back");
    assert_eq!((paper.commands.len(), paper.fed), (6_000, 6_000));
    assert!(paper.sent.len() > 4, "back on the bus: {}", paper.sent.len());
}

/// Fault words and answers that were sent.
fn messages(paper: &Paper) -> impl Iterator<Item = FromDrive> {
    paper.sent.iter().filter_map(|frame| FromDrive::decode(frame).ok()).map(|(_, message)| message)
}

#[test]
fn a_failed_self_test_is_a_fault_that_says_which_and_why_the_device_started_can_be_asked() {
    let addresses = Node::new(Identity::default(), Board::BENCH).addresses();
    for (from, number, value) in [(0, 303, 0b1), (0, 302, 4), (8_000, 303, 0b1001)] {
        let side = run(10_000, |tick, paper| {
            paper.failed = if tick < 7_000 { SelfTests::RAM } else { SelfTests::RAM | SelfTests::STACK };
            if tick == 6_000.max(from) {
                assert!(
                    messages(paper).any(|message| matches!(message, FromDrive::CriticalFault { faults, .. } if faults == FaultWord::EMERGENCY_SHUTDOWN))
                );
                paper.sent.clear();
                paper.arriving.push_back(ToDrive::RequestParameter { number }.encode(addresses));
            }
            true
        });
        let answer = FromDrive::Parameter { number, value, status: ParameterStatus::Done };
        assert!(messages(&side.0.borrow()).any(|message| message == answer), "parameter {number}");
    }
}

#[test]
fn a_board_rests_until_the_motor_is_driven_and_when_it_is_no_more() {
    let addresses = Node::new(Identity::default(), Board::BENCH).addresses();
    let side = run(14_000, |tick, paper| {
        if tick % 500 == 0 {
            let mode = if (7_000..9_000).contains(&tick) { MotorMode::Drive } else { MotorMode::Standby };
            paper.arriving.push_back(ToDrive::MotorCommand { speed: 500 }.encode(addresses));
            paper.arriving.push_back(request(mode));
        }
        true
    });
    assert_eq!(side.0.borrow().rests, [true, false, true]);
}
