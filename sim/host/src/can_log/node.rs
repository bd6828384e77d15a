//! Messages of TX-Drivers and of their masters (eddyCAN): what is in them as named values.

use super::column::{Signal, Table, Value, Values};
use narx_core::bus::Frame;
use narx_core::bus::eddycan::{
    Channels, CobId, DecodeError, ErrorCode, FromNode, Layout, NmtCommand, NmtState, PdoKind, Reading,
    SdoAction, SdoAnswer, SdoOutcome, SdoRequest, Target, ToNode,
};
use narx_core::eddycan::OBJECTS;

/// A kind of message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NodeMessage {
    /// Name as Table 3 of the specification prints it.
    pub name: &'static str,
    /// A node sends it, or else the master.
    pub from_node: bool,
}

/// Every kind, in the order of the priorities.
pub const MESSAGES: [NodeMessage; 10] = [
    NodeMessage { name: "NMT", from_node: false },
    NodeMessage { name: "SYNC", from_node: false },
    NodeMessage { name: "Error", from_node: true },
    NodeMessage { name: "PDO1", from_node: true },
    NodeMessage { name: "PDO2", from_node: true },
    NodeMessage { name: "PDO3", from_node: true },
    NodeMessage { name: "PDO3 request", from_node: false },
    NodeMessage { name: "SDO answer", from_node: true },
    NodeMessage { name: "SDO request", from_node: false },
    NodeMessage { name: "Heartbeat", from_node: true },
];

/// Place in [`MESSAGES`].
const NMT: usize = 0;
const SYNC: usize = 1;
const ERROR: usize = 2;
const PDO: usize = 3;
const PDO_REQUEST: usize = 6;
const SDO_ANSWER: usize = 7;
const SDO_REQUEST: usize = 8;
const HEARTBEAT: usize = 9;

/// Commands and outcomes of an SDO, as columns number them.
const ACTIONS: [&str; 4] = ["read", "write", "abort", "unknown"];
const OUTCOMES: [&str; 3] = ["written", "value", "abort"];

/// Content of a message: its place in [`MESSAGES`], and the values in the order of its signals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decoded {
    /// Which one.
    pub place: usize,
    values: [Value; 6],
    count: usize,
}

impl Decoded {
    fn new<const N: usize>(place: usize, values: [Value; N]) -> Self {
        let mut all = [Value::Number(0); 6];
        all.iter_mut().zip(values).for_each(|(to, value)| *to = value);
        Self { place, values: all, count: N }
    }

    /// The values.
    pub fn values(&self) -> &[Value] {
        &self.values[..self.count]
    }
}

/// The signals of a message of this place.
pub fn signals(place: usize) -> Vec<Signal> {
    tables().nth(place).map_or_else(Vec::new, |table| table.signals)
}

/// An empty table for every message.
pub(super) fn tables() -> impl Iterator<Item = Table> {
    let rows = MESSAGES.iter().enumerate();
    rows.map(|(place, message)| Table::new(message.name.to_owned(), message.from_node, columns(place)))
}

fn columns(place: usize) -> Vec<(Signal, Values)> {
    let node = || number("Node");
    let sdo = |action, names: &[&'static str]| {
        let names = names.iter().enumerate().map(|(value, name)| (value as u16, *name));
        vec![
            node(),
            number("Index"),
            number("Subindex"),
            code("Entry", entries()),
            code(action, names.collect()),
            number("Value"),
        ]
    };
    match place {
        NMT => vec![node(), code("Command", NmtCommand::ALL.map(|it| (it as u16, command(it))).to_vec())],
        ERROR => vec![node(), code("Code", ErrorCode::ALL.map(|it| (it as u16, it.meaning())).to_vec())],
        PDO_REQUEST => vec![node(), number("Bytes")],
        SDO_ANSWER => sdo("Outcome", &OUTCOMES),
        SDO_REQUEST => sdo("Action", &ACTIONS),
        HEARTBEAT => vec![node(), code("State", NmtState::ALL.map(|it| (it as u16, state(it))).to_vec())],
        SYNC => vec![],
        _ => vec![
            node(),
            quantity("Position 1", "mm"),
            quantity("Position 2", "mm"),
            quantity("Encoder", "counts"),
        ],
    }
}

/// Decodes a frame. The length of a PDO tells what it carries, but for those of 8 bytes: `encoder` says
/// whether those of the node carry an encoder's position.
///
/// # Errors
/// The frame is no message of this protocol, or a malformed one.
pub fn decode(frame: &Frame, encoder: bool) -> Result<Decoded, DecodeError> {
    let id = CobId::decode(frame.id())?;
    match id {
        CobId::Nmt | CobId::Sync | CobId::SdoRequest(_) => to_node(frame),
        CobId::Pdo(PdoKind::Remote, _) if frame.is_remote() => to_node(frame),
        _ => from_node(frame, layout(frame.payload().len(), encoder)),
    }
}

fn to_node(frame: &Frame) -> Result<Decoded, DecodeError> {
    Ok(match ToNode::decode(frame)? {
        ToNode::Nmt { command, target } => {
            let node = match target {
                Target::All => 0,
                Target::Node(node) => node.raw(),
            };
            Decoded::new(NMT, [Value::Number(node.into()), Value::Code(command as u16)])
        }
        ToNode::Sync => Decoded::new(SYNC, []),
        ToNode::RequestPdo { node, bytes } => {
            Decoded::new(PDO_REQUEST, [node.raw(), bytes].map(|value| Value::Number(value.into())))
        }
        ToNode::Sdo { node, request: SdoRequest { index, subindex, action } } => {
            let (action, value) = match action {
                SdoAction::Read => (0, 0),
                SdoAction::Write { size, data } => (1, sized(data, size)),
                SdoAction::Abort { code } => (2, code),
                SdoAction::Unknown { command } => (3, command.into()),
            };
            sdo(SDO_REQUEST, node.raw(), (index, subindex), action, value)
        }
    })
}

fn from_node(frame: &Frame, layout: Layout) -> Result<Decoded, DecodeError> {
    let (node, message) = FromNode::decode(frame, layout)?;
    let received = Value::Number(node.raw().into());
    Ok(match message {
        FromNode::Error { code } => Decoded::new(ERROR, [received, Value::Code(code)]),
        FromNode::Pdo { kind, reading: Reading { positions: [first, second], encoder } } => {
            // 2^-27 mm: exact.
            let position = |raw: i32| f64::from(raw) / f64::from(1 << 27);
            let second = if layout.channels == Channels::Dual { position(second.raw()) } else { f64::NAN };
            // As the EDS has it; a rotary encoder's count is the same modulo 65536.
            let encoder = if layout.encoder { f64::from(encoder as i16) } else { f64::NAN };
            let [first, second, encoder] = [position(first.raw()), second, encoder].map(Value::Quantity);
            Decoded::new(PDO + kind as usize - PdoKind::Timer as usize, [received, first, second, encoder])
        }
        FromNode::Sdo(SdoAnswer { index, subindex, outcome }) => {
            let (outcome, value) = match outcome {
                SdoOutcome::Written => (0, 0),
                SdoOutcome::Value(value) => (1, value.number()),
                SdoOutcome::Aborted { code } => (2, code),
            };
            sdo(SDO_ANSWER, node.raw(), (index, subindex), outcome, value)
        }
        FromNode::Heartbeat(state) => Decoded::new(HEARTBEAT, [received, Value::Code(state as u16)]),
    })
}

/// The layout of so many bytes; of another number any, which then does not fit.
const fn layout(bytes: usize, encoder: bool) -> Layout {
    match bytes {
        8 => Layout { channels: Channels::Dual, encoder },
        6 => Layout { channels: Channels::Single, encoder: true },
        _ => Layout { channels: Channels::Single, encoder: false },
    }
}

fn sdo(place: usize, node: u8, (index, subindex): (u16, u8), what: u16, value: u32) -> Decoded {
    // Where an entry has no subindex, any will do.
    let entry = OBJECTS
        .iter()
        .position(|row| row.index == index && row.subindex.is_none_or(|known| known == subindex));
    Decoded::new(
        place,
        [
            Value::Number(node.into()),
            Value::Number(index.into()),
            Value::Number(subindex.into()),
            Value::Code(entry.unwrap_or(OBJECTS.len()) as u16),
            Value::Code(what),
            Value::Number(value.into()),
        ],
    )
}

/// Only the bytes that count.
fn sized(data: [u8; 4], size: Option<u8>) -> u32 {
    let unused = 32 - 8 * u32::from(size.unwrap_or(4).clamp(1, 4));
    u32::from_le_bytes(data) << unused >> unused
}

/// Names of the entries by their place in Table 4.
fn entries() -> Vec<(u16, &'static str)> {
    let rows = OBJECTS.iter().map(|row| row.name).chain(["unknown"]);
    rows.enumerate().map(|(place, name)| (place as u16, name)).collect()
}

const fn command(command: NmtCommand) -> &'static str {
    match command {
        NmtCommand::Start => "start",
        NmtCommand::Stop => "stop",
        NmtCommand::PreOperational => "pre-operational",
        NmtCommand::Reset => "reset",
    }
}

const fn state(state: NmtState) -> &'static str {
    match state {
        NmtState::BootUp => "boot-up",
        NmtState::Stopped => "stopped",
        NmtState::Operational => "operational",
        NmtState::PreOperational => "pre-operational",
    }
}

fn number(name: &'static str) -> (Signal, Values) {
    (Signal { name, unit: "", names: Vec::new() }, Values::Number(Vec::new()))
}

fn quantity(name: &'static str, unit: &'static str) -> (Signal, Values) {
    (Signal { name, unit, names: Vec::new() }, Values::Quantity(Vec::new()))
}

fn code(name: &'static str, names: Vec<(u16, &'static str)>) -> (Signal, Values) {
    (Signal { name, unit: "", names }, Values::Code(Vec::new()))
}
