//! Invariants of a drive under any input: an observer that knows the protocol but not the drive's inner
//! state.

use narx_core::bus::narmotion::{
    Addresses, FromDrive, MessageId, MessageKind, MotorMode, Priority, RequestWord, ToDrive,
};
use narx_core::bus::{ErrorState, Frame, Id};
use narx_core::dictionary::{Dictionary, Parameters, number};
use narx_core::motor::machine::state::TRANSITIONS;
use narx_core::motor::{Drive, PwmCommand, State, Step};
use narx_core::node::Node;

/// Ticks until a command is in the control tick: eight may wait before it, one is taken per tick, and
/// coefficients go first.
const LATE: u64 = 20;

pub(crate) struct Watch {
    addresses: Addresses,
    /// Time-out of the command (parameter 114), ticks. It is written while the drive is stopped, and starts
    /// nothing.
    timeout: u64,
    state: State,
    /// Time since which neither Drive nor Reverse is requested.
    idle: Option<u64>,
    /// Time of the last command that restarted the time-out.
    fed: Option<u64>,
    /// The controller has been off the bus: frames were dropped.
    pub(crate) off: bool,
    /// The node has requested a restart of the shell.
    pub(crate) reboots: bool,
    /// Numbers of parameters whose reads are still to be answered.
    owed: Vec<u16>,
}

impl Watch {
    pub(crate) fn new(addresses: Addresses, parameters: &Parameters) -> Self {
        Self {
            addresses,
            timeout: timeout(parameters),
            state: State::Initialization,
            idle: Some(0),
            fed: None,
            off: false,
            reboots: false,
            owed: Vec::new(),
        }
    }

    /// Gives the node a frame. A frame that is not a valid command of the master must change nothing but a
    /// counter.
    pub(crate) fn give(&mut self, frame: &Frame, node: &mut Node, now: u64) {
        let ours = MessageId::of(frame).map(|id| id.destination == self.addresses.drive);
        let message = ToDrive::decode(frame);
        let accepted =
            matches!((ours, message), (Ok(true), Ok((id, _))) if id.source == self.addresses.master);
        if !accepted {
            let mut twin = node.clone();
            // The simplest frame of the same kind.
            match (ours, message) {
                (Ok(false), _) => {}
                (Ok(true), Ok(_)) => twin.handle_frame(&stranger(self.addresses)),
                (Err(error), _) | (_, Err(error)) if error.is_malformed() => {
                    twin.handle_frame(&Frame::full(Id::standard(0).expect("eleven bits"), [0; 8]));
                }
                _ => twin.handle_frame(&stranger(self.addresses)),
            }
            node.handle_frame(frame);
            assert!(*node == twin, "changed by {frame:?}");
            return;
        }
        let Ok((_, message)) = message else { return };
        match message {
            ToDrive::RequestWord(RequestWord { mode: MotorMode::Drive | MotorMode::Reverse }) => {
                (self.idle, self.fed) = (None, Some(now));
            }
            ToDrive::RequestWord(_) => {
                self.idle = self.idle.or(Some(now));
                self.fed = Some(now);
            }
            ToDrive::MotorCommand { .. } => self.fed = Some(now),
            ToDrive::RequestParameter { number } => self.owed.push(number),
            _ => {}
        }
        let lost = frames_lost(node);
        node.handle_frame(frame);
        // Off the bus the frames wait and are lost: an answer for which there is no room is counted now, the
        // others when the bus is back.
        let off = node.read_parameter(number::BUS_STATE) == Some(ErrorState::BusOff as i32);
        let room = i64::from(off);
        assert!((0..=room).contains(&(frames_lost(node) - lost)), "an answer is lost");
        if let ToDrive::SetParameter { number, .. } = message
            && let Some(row) = Dictionary::row(number)
        {
            let raw = node.parameters().raw(number);
            assert!(row.accepts(raw), "{row} is {raw}");
        }
        self.timeout = self.timeout.max(timeout(node.parameters()));
    }

    /// Checks a tick.
    pub(crate) fn tick(&mut self, drive: &Drive, command: &PwmCommand, node: &Node, now: u64) {
        let state = drive.state();
        let allowed =
            state == self.state || TRANSITIONS.iter().any(|row| (row.from, row.to) == (self.state, state));
        assert!(allowed, "from {} to {}", self.state.name(), state.name());
        self.state = state;
        let on = command.step != Step::Coast || !command.commutations.is_empty();
        assert!(!on || state.is_driving(), "the bridge is on in {}: {command:?}", state.name());
        if state.is_driving() {
            assert!(self.idle.is_none_or(|idle| now - idle <= LATE), "nobody asks for {}", state.name());
            let fed = self.fed.expect("it was asked for");
            assert!(now - fed <= self.timeout + LATE, "{} with a silent master", state.name());
        }
        if node.status().state == state {
            self.timeout = timeout(node.parameters()).max(if state.is_driving() { self.timeout } else { 0 });
        }
    }

    /// Checks a frame of the drive.
    pub(crate) fn received(&mut self, frame: &Frame) {
        let (id, message) = FromDrive::decode(frame).expect("a message of a drive");
        assert_eq!((id.source, id.destination), (self.addresses.drive, self.addresses.master));
        assert_eq!((id.priority, id.kind), (Priority::Low, MessageKind::SlaveTx));
        assert_eq!(message.encode(self.addresses), *frame);
        if let FromDrive::Parameter { number, .. } = message
            && let Some(place) = self.owed.iter().position(|owed| *owed == number)
        {
            self.owed.remove(place);
        }
    }

    /// Checks the end: every value within its range, every read answered.
    pub(crate) fn end(&self, node: &Node) {
        for (row, raw) in node.parameters().iter() {
            assert!(row.accepts(raw), "{row} is {raw}");
        }
        if !self.off {
            assert!(self.owed.is_empty(), "reads without an answer");
        }
    }
}

fn frames_lost(node: &Node) -> i64 {
    let lost = node.read_parameter(number::FRAMES_LOST).expect("it is known");
    i64::from(lost as u32)
}

fn timeout(parameters: &Parameters) -> u64 {
    parameters.raw(number::CAN_TIMEOUT).unsigned_abs() as u64 * 10
}

/// A valid message from an address that is not the master's.
fn stranger(addresses: Addresses) -> Frame {
    let other = Addresses { master: !addresses.master, ..addresses };
    ToDrive::RequestBuildInfo.encode(other)
}
