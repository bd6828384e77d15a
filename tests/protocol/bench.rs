//! A node with a master beside it, shared by the node suites.

use narx_core::bus::narmotion::{Addresses, FromDrive, MotorMode, ParameterStatus, RequestWord, ToDrive};
use narx_core::bus::{Frame, Id};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::machine::event::{Command, Event, RunRequest, Status};
use narx_core::motor::machine::state::State;
use narx_core::motor::sense::front_end::Board;
use narx_core::node::{Identity, Node};
use narx_core::units::ElectricalSpeed;

pub(crate) const IDENTITY: Identity = Identity {
    build_number: 42,
    source_modified: false,
    build_date: 20_261_120,
    hardware_release: 3,
    software_release: 0x0102,
};

/// A node in the state that a test needs, and its master.
pub(crate) struct Bench {
    pub(crate) node: Node,
}

impl Bench {
    /// A node after power-up, in Standby, with its start-up events taken.
    pub(crate) fn new() -> Self {
        Self::with_parameters(Parameters::new())
    }

    pub(crate) fn with_parameters(parameters: Parameters) -> Self {
        Self::on_board(Board::BENCH, parameters)
    }

    pub(crate) fn on_board(board: Board, parameters: Parameters) -> Self {
        let mut bench = Self { node: Node::with_parameters(IDENTITY, board, parameters) };
        bench.enter(State::Standby);
        bench.events();
        bench.messages();
        bench
    }

    /// Reports a state from the tick, at standstill and with the master received.
    pub(crate) fn enter(&mut self, state: State) {
        self.node.handle_status(Status { state, standstill: true, ..Status::default() });
    }

    pub(crate) fn send(&mut self, message: ToDrive) {
        self.node.handle_frame(&message.encode(Addresses::FACTORY));
    }

    pub(crate) fn request(&mut self, mode: MotorMode) {
        self.send(ToDrive::RequestWord(RequestWord { mode }));
    }

    /// Writes over the bus; returns value and status of the answer.
    pub(crate) fn write(&mut self, number: u16, value: i32) -> (i32, ParameterStatus) {
        self.send(ToDrive::SetParameter { number, value });
        self.answer(number)
    }

    /// Reads over the bus.
    pub(crate) fn read(&mut self, number: u16) -> (i32, ParameterStatus) {
        self.send(ToDrive::RequestParameter { number });
        self.answer(number)
    }

    fn answer(&mut self, number: u16) -> (i32, ParameterStatus) {
        match self.messages().as_slice() {
            [FromDrive::Parameter { number: answered, value, status }] if *answered == number => {
                (*value, *status)
            }
            other => panic!("one answer expected for parameter {number}: {other:?}"),
        }
    }

    pub(crate) fn messages(&mut self) -> Vec<FromDrive> {
        let frames = std::iter::from_fn(|| self.node.poll_frame());
        frames.map(|frame| FromDrive::decode(&frame).expect("the node's own frame").1).collect()
    }

    pub(crate) fn events(&mut self) -> Vec<Event> {
        std::iter::from_fn(|| self.node.poll_event()).collect()
    }

    /// Commands to the tick: set-points, with a request if there is one.
    pub(crate) fn commands(&mut self) -> Vec<(Option<RunRequest>, ElectricalSpeed)> {
        let asked = |event| match event {
            Event::Command(Command { request, speed }) => Some((Some(request), speed)),
            Event::SetPoint(speed) => Some((None, speed)),
            _ => None,
        };
        self.events().into_iter().filter_map(asked).collect()
    }

    pub(crate) fn refused(&self) -> i32 {
        self.node.read_parameter(number::REFUSED_FRAMES).unwrap()
    }

    pub(crate) fn malformed(&self) -> i32 {
        self.node.read_parameter(number::MALFORMED_FRAMES).unwrap()
    }
}

pub(crate) fn frame(id: u32, bytes: u64) -> Frame {
    Frame::full(Id::extended(id).unwrap(), bytes.to_be_bytes())
}

/// Electrical speed of a mechanical one in rpm.
pub(crate) fn speed(rpm: i64, pole_pairs: i64) -> ElectricalSpeed {
    ElectricalSpeed::from_ratio(rpm * pole_pairs, 60)
}
