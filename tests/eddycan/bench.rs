//! A driver with its master beside it, shared by the suites.

use narx_core::bus::eddycan::{
    Bitrate, Channels, CobId, FromNode, Layout, NmtCommand, NmtState, NodeId, PdoKind, Position, Reading,
    SdoAction, SdoAnswer, SdoOutcome, SdoRequest, SdoValue, Target, ToNode,
};
use narx_core::bus::{Frame, Id};
use narx_core::eddycan::{Configuration, Entry, MeasuringRange, Sample, TxDriver, Variant};

pub(crate) const FIRMWARE: u16 = 0x0103;
/// Samples per second of the benches.
pub(crate) const RATE: u32 = 40_000;

/// Variant of a driver that measures 0 to 4 mm on every channel.
pub(crate) fn variant(channels: Channels) -> Variant {
    let range = MeasuringRange::new(mm(0), mm(4)).unwrap();
    Variant { channels, ranges: [range; 2], sample_rate: RATE, firmware: FIRMWARE }
}

pub(crate) const fn mm(millimetres: i32) -> Position {
    Position::from_raw(millimetres << 27)
}

pub(crate) fn node(raw: u8) -> NodeId {
    NodeId::new(raw).unwrap()
}

/// Factory values, except these.
pub(crate) fn configured(values: &[(Entry, u32)]) -> Configuration {
    let mut configuration = Configuration::new();
    for &(entry, value) in values {
        configuration.set(entry, value).unwrap();
    }
    configuration
}

/// Frame with this identifier and these data bytes.
pub(crate) fn frame(id: u16, data: &[u8]) -> Frame {
    Frame::data(Id::standard(id).unwrap(), data).unwrap()
}

pub(crate) struct Bench {
    pub(crate) driver: TxDriver,
    pub(crate) now: u64,
}

impl Bench {
    /// Powers up a driver, takes its boot-up message, and gives it one sample.
    pub(crate) fn new(channels: Channels, values: &[(Entry, u32)]) -> Self {
        let mut bench = Self::dark(channels, values);
        bench.driver.handle_sample(SAMPLE);
        bench
    }

    /// Powers up a driver without a sample.
    pub(crate) fn dark(channels: Channels, values: &[(Entry, u32)]) -> Self {
        let mut bench = Self { driver: TxDriver::new(variant(channels), configured(values)), now: 1_000_000 };
        let id = CobId::Heartbeat(bench.driver.node()).encode();
        assert_eq!(bench.poll().first(), Some(&Frame::data(id, &[0]).unwrap()), "boot-up comes first");
        bench
    }

    pub(crate) fn in_state(state: NmtState, channels: Channels, values: &[(Entry, u32)]) -> Self {
        let mut bench = Self::new(channels, values);
        bench.enter(state);
        bench
    }

    pub(crate) fn enter(&mut self, state: NmtState) {
        let command = match state {
            NmtState::Operational => NmtCommand::Start,
            NmtState::Stopped => NmtCommand::Stop,
            NmtState::PreOperational | NmtState::BootUp => NmtCommand::PreOperational,
        };
        self.send(ToNode::Nmt { command, target: Target::All });
        assert_eq!(self.driver.state(), state);
    }

    pub(crate) fn send(&mut self, message: ToNode) {
        self.give(&message.encode());
    }

    pub(crate) fn give(&mut self, frame: &Frame) {
        self.driver.handle_frame(frame, self.now);
    }

    /// Lets time pass in one step.
    pub(crate) fn wait(&mut self, microseconds: u64) -> Vec<Frame> {
        self.now += microseconds;
        self.poll()
    }

    pub(crate) fn poll(&mut self) -> Vec<Frame> {
        self.driver.poll(self.now);
        self.frames()
    }

    pub(crate) fn frames(&mut self) -> Vec<Frame> {
        std::iter::from_fn(|| self.driver.poll_frame()).collect()
    }

    pub(crate) fn messages(&mut self) -> Vec<FromNode> {
        let (node, layout) = (self.driver.node(), self.driver.layout());
        self.frames().iter().map(|frame| decode(frame, node, layout)).collect()
    }

    /// PDOs that are sent within a time; the driver is polled at every microsecond at which one is due.
    pub(crate) fn pdos(&mut self, duration: u64) -> Vec<(u64, PdoKind, Reading)> {
        let end = self.now + duration;
        let mut found = Vec::new();
        while self.now < end {
            self.driver.poll(self.now);
            for message in self.messages() {
                if let FromNode::Pdo { kind, reading } = message {
                    found.push((self.now, kind, reading));
                }
            }
            self.now = self.driver.next_poll().clamp(self.now + 1, end);
        }
        found
    }

    pub(crate) fn sdo(&mut self, index: u16, subindex: u8, action: SdoAction) -> Vec<FromNode> {
        let request = SdoRequest { index, subindex, action };
        self.send(ToNode::Sdo { node: self.driver.node(), request });
        self.messages()
    }

    /// Returns the outcome of a request that has exactly one answer.
    pub(crate) fn ask(&mut self, index: u16, subindex: u8, action: SdoAction) -> SdoOutcome {
        match self.sdo(index, subindex, action).as_slice() {
            [FromNode::Sdo(answer)] => {
                assert_eq!(
                    (answer.index, answer.subindex),
                    (index, subindex),
                    "the answer names the request"
                );
                answer.outcome
            }
            other => panic!("one answer expected: {other:?}"),
        }
    }

    pub(crate) fn read(&mut self, index: u16, subindex: u8) -> SdoOutcome {
        self.ask(index, subindex, SdoAction::Read)
    }

    pub(crate) fn write(&mut self, index: u16, subindex: u8, value: u32) -> SdoOutcome {
        self.ask(index, subindex, SdoAction::Write { size: None, data: value.to_le_bytes() })
    }

    /// Writes an entry, which must be accepted.
    pub(crate) fn put(&mut self, entry: Entry, value: u32) {
        let object = entry.object();
        let outcome = self.write(object.index, object.subindex.unwrap_or(0), value);
        assert_eq!(outcome, SdoOutcome::Written, "{} = {value}", object.name);
    }

    /// Restarts as a shell does, with the stored values.
    pub(crate) fn restart(&mut self, stored: Configuration, channels: Channels) {
        self.driver = TxDriver::new(variant(channels), stored);
    }
}

pub(crate) const SAMPLE: Sample = Sample { positions: [mm(1), mm(-2)], counter: 500 };

pub(crate) fn decode(frame: &Frame, node: NodeId, layout: Layout) -> FromNode {
    let (from, message) = FromNode::decode(frame, layout).expect("the driver's own frame");
    assert_eq!(from, node);
    message
}

pub(crate) fn value(value: SdoValue) -> SdoOutcome {
    SdoOutcome::Value(value)
}

pub(crate) fn answer(index: u16, subindex: u8, outcome: SdoOutcome) -> FromNode {
    FromNode::Sdo(SdoAnswer { index, subindex, outcome })
}

pub(crate) const STATES: [NmtState; 3] = [NmtState::PreOperational, NmtState::Operational, NmtState::Stopped];

pub(crate) const CHANNELS: [Channels; 2] = [Channels::Single, Channels::Dual];

pub(crate) const BITRATES: [(Bitrate, u32); 5] = [
    (Bitrate::K50, 50_000),
    (Bitrate::K100, 100_000),
    (Bitrate::K250, 250_000),
    (Bitrate::K500, 500_000),
    (Bitrate::M1, 1_000_000),
];
