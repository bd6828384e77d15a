//! Target: the TX-Driver with frames, samples, time and its shell's answers in any order, among them
//! restarts.

use crate::program::Program;
use narx_core::bus::eddycan::{
    Channels, DecodeError, FromNode, NmtCommand, NmtState, NodeId, PdoKind, Position, SdoAction, SdoRequest,
    Target, ToNode,
};
use narx_core::bus::{BusState, ErrorState, Frame, Id};
use narx_core::eddycan::{Configuration, MeasuringRange, OBJECTS, STORED, Sample, TxDriver, Variant};

/// Largest number of waiting frames: boot-up, three errors, heartbeat, three PDOs, four answers.
const WAITING_MAX: usize = 12;

/// Runs an input. First byte: bit 0 for a second channel. Steps follow.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    let channels = if program.byte() & 1 != 0 { Channels::Dual } else { Channels::Single };
    let range = MeasuringRange::new(Position::MIN, Position::MAX).expect("it begins before it ends");
    let variant = Variant { channels, ranges: [range; 2], sample_rate: 40_000, firmware: 0x0102 };
    let mut node = Node {
        driver: TxDriver::new(variant, Configuration::new()),
        variant,
        stored: Configuration::new(),
        storing: None,
        now: 0,
    };
    while !program.is_over() {
        node.handle(&mut program);
        node.check();
    }
}

struct Node {
    driver: TxDriver,
    variant: Variant,
    stored: Configuration,
    storing: Option<Configuration>,
    now: u64,
}

impl Node {
    fn handle(&mut self, program: &mut Program<'_>) {
        match program.byte() % 8 {
            0 => self.give(&program.frame()),
            // An SDO to this node: any command for an existing entry.
            1 => {
                let (place, command, data) = (program.byte(), program.byte(), program.array::<4>());
                let object = &OBJECTS[usize::from(place) % OBJECTS.len()];
                let size = [None, Some(1), Some(2), Some(4)][usize::from(command >> 2 & 3)];
                let action = match command & 3 {
                    0 => SdoAction::Read,
                    _ => SdoAction::Write {
                        size: size.or(Some(object.kind.size())).filter(|_| command & 3 != 3),
                        data,
                    },
                };
                let request =
                    SdoRequest { index: object.index, subindex: object.subindex.unwrap_or(place), action };
                self.give(&ToNode::Sdo { node: self.driver.node(), request }.encode());
            }
            // NMT, SYNC or a remote request.
            2 => self.give(&short(program.byte(), self.driver.node(), self.driver.layout().length())),
            3 => self.pass(program.byte().into()),
            4 => self.pass(u64::from(program.word()) * 16),
            5 => {
                let positions = [program.long(), program.long()].map(|raw| Position::from_raw(raw as i32));
                self.driver.handle_sample(Sample { positions, counter: program.word() });
            }
            6 => {
                let error = [ErrorState::Active, ErrorState::Passive, ErrorState::BusOff];
                let error = error[usize::from(program.byte() % 3)];
                self.driver.handle_bus_state(BusState { error, ..BusState::default() });
            }
            _ => self.store(program.byte()),
        }
    }

    /// Checks a frame: NMT alone changes the state, a write in Pre-operational alone the configuration, and a
    /// frame for another node changes nothing.
    fn give(&mut self, frame: &Frame) {
        let before = self.driver.clone();
        let message = ToNode::decode(frame);
        self.driver.handle_frame(frame, self.now);
        let (nmt, write, meant) = match message {
            Ok(ToNode::Nmt { target, .. }) => (true, false, target.includes(before.node())),
            Ok(ToNode::Sdo { node, request }) => {
                let write = matches!(request.action, SdoAction::Write { .. });
                (false, write && before.state() == NmtState::PreOperational, node == before.node())
            }
            Ok(ToNode::RequestPdo { node, .. }) => (false, false, node == before.node()),
            Ok(ToNode::Sync) => (false, false, true),
            Err(DecodeError::NmtCommand(target)) => (false, false, target.includes(before.node())),
            Err(_) => (false, false, false),
        };
        if !meant {
            let mut twin = before.clone();
            twin.handle_frame(&nobody(), self.now);
            assert!(self.driver == twin, "changed by {frame:?}");
        }
        assert!(nmt || self.driver.state() == before.state());
        assert!(write || self.driver.configuration() == before.configuration());
    }

    fn pass(&mut self, microseconds: u64) {
        self.now += microseconds;
        self.driver.poll(self.now);
        assert!(
            self.driver.next_poll() > self.now
                || self.driver.state() == NmtState::Operational
                || self.restarting()
        );
        let mut sent = 0;
        while let Some(frame) = self.driver.poll_frame() {
            self.received(&frame);
            sent += 1;
        }
        assert!(sent <= WAITING_MAX, "{sent} frames at once");
        if self.driver.take_reset() {
            // The reset is reported once, no frame follows, and the shell begins anew with the stored values.
            assert!(!self.driver.take_reset() && self.driver.poll_frame().is_none());
            self.storing = None;
            self.driver = TxDriver::new(self.variant, self.stored);
        }
    }

    /// Returns whether a restart is due: until then no message is taken and nothing is done.
    fn restarting(&self) -> bool {
        let mut twin = self.driver.clone();
        twin.handle_bus_state(BusState::default());
        twin.poll(self.now.saturating_add(3_000_000));
        twin.poll_frame().is_none()
    }

    fn received(&self, frame: &Frame) {
        let (node, message) =
            FromNode::decode(frame, self.driver.layout()).expect("a message of such a node");
        assert_eq!((node, message.encode(node, self.driver.layout())), (self.driver.node(), *frame));
        let state = self.driver.state();
        match message {
            FromNode::Pdo { kind, .. } => {
                assert_eq!(state, NmtState::Operational);
                assert!(kind != PdoKind::Timer || self.driver.period().is_some());
            }
            FromNode::Sdo(_) => assert_ne!(state, NmtState::Stopped),
            FromNode::Heartbeat(said) => assert!(said == state || said == NmtState::BootUp),
            FromNode::Error { .. } => {}
        }
    }

    /// Stores as the shell, or reports the result of a store.
    fn store(&mut self, what: u8) {
        match self.storing.take() {
            None => self.storing = self.driver.poll_store(),
            Some(configuration) => {
                let done = what & 1 == 0;
                if done {
                    self.stored = configuration;
                }
                self.driver.handle_store(done);
            }
        }
    }

    fn check(&self) {
        for configuration in [*self.driver.configuration(), self.stored] {
            let values = <[u32; STORED]>::from(configuration);
            assert!(OBJECTS.iter().zip(values).all(|(row, value)| row.accepts(value)), "{values:?}");
            assert_eq!(Configuration::try_from(values), Ok(configuration));
        }
        assert_ne!(self.driver.state(), NmtState::BootUp);
    }
}

/// A frame that no TX-Driver takes.
fn nobody() -> Frame {
    Frame::full(Id::extended(0x1234_5678).expect("29 bits"), [0; 8])
}

fn short(what: u8, node: NodeId, bytes: u8) -> Frame {
    let target = if what & 8 != 0 { Target::All } else { Target::Node(node) };
    match what & 7 {
        place @ 0..=3 => ToNode::Nmt { command: NmtCommand::ALL[usize::from(place)], target },
        4 | 5 => ToNode::Sync,
        _ => ToNode::RequestPdo { node, bytes },
    }
    .encode()
}
