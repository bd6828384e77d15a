//! eddyCAN messages, for a program that needs only the protocol.

use super::node;
use crate::frame::narx_frame_t;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::bus::eddycan::{
    Channels, DecodeError, FromNode, Layout, NmtCommand, NmtState, PdoKind, Position, Reading, SdoAction,
    SdoAnswer, SdoOutcome, SdoRequest, SdoValue, Target, ToNode,
};

/// Kind of a message.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum narx_tx_kind_t {
    /// Master: NMT command `command` to node `node`, or to all for 0: 1 start, 2 stop, 128 pre-operational,
    /// 129 reset.
    Nmt = 0,
    /// Master: SYNC; all nodes sample now and send PDO2.
    Sync = 1,
    /// Master: request to `node` for PDO3, of `size` bytes.
    RequestPdo = 2,
    /// Master: read request for entry `index`, `subindex` of `node`.
    Read = 3,
    /// Master: request to write `value` to the entry `index`, `subindex` of `node`; `size` is 1 to 4 bytes,
    /// or 0 if only the node knows it.
    Write = 4,
    /// Node: boot-up or heartbeat; `command` is its state: 0 boot-up, 4 Stopped, 5 Operational, 127
    /// Pre-Operational.
    Heartbeat = 5,
    /// Node: an error; `value` is its code.
    Error = 6,
    /// Node: PDO with `positions` and `encoder`, as far as the layout has them; `command` is the number of
    /// the PDO, 1 to 3.
    Pdo = 7,
    /// Node: the entry was written.
    Written = 8,
    /// Node: the entry holds `value`, of `size` bytes.
    Value = 9,
    /// Master or node: the request was refused or is aborted; `value` is the abort code (Table 10).
    Abort = 10,
}

/// Layout of a node's PDOs.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_tx_layout_t {
    /// Number of sensors: 1 or 2.
    pub channels: u8,
    /// Not 0: the encoder's value follows.
    pub encoder: u8,
}

/// An eddyCAN message (PROTOCOL.md, section 10). Fields that are not named at its kind are ignored.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_tx_message_t {
    /// Kind: a narx_tx_kind_t.
    pub kind: u8,
    /// Node-id, 1 to 127.
    pub node: u8,
    /// NMT command or state, or number of the PDO.
    pub command: u8,
    /// Subindex of the entry.
    pub subindex: u8,
    /// Index of the entry.
    pub index: u16,
    /// Counts of the encoder.
    pub encoder: u16,
    /// Number of bytes of a value.
    pub size: u8,
    /// Not 0: the node sends this NARX_TX_KIND_ABORT; else the master does.
    pub from_node: u8,
    /// Value, error code or abort code.
    pub value: u32,
    /// Position of each channel, 2^-27 mm.
    pub positions: [i32; 2],
}

use narx_tx_kind_t as Kind;

/// Decodes a frame of a bus whose nodes have this layout. Returns NARX_ERROR_NOT_A_MESSAGE if it is no
/// eddyCAN message, or one of another layout; NARX_ERROR_FIELD if a field has an undefined value. Any
/// context; no state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_message_decode(
    frame: *const narx_frame_t,
    layout: *const narx_tx_layout_t,
    message: *mut narx_tx_message_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let layout = pointer::read(layout)?.try_into()?;
        let frame = pointer::read(frame)?.try_into()?;
        let decoded = match ToNode::decode(&frame) {
            Ok(message) => message.try_into()?,
            // Messages of nodes have other identifiers.
            Err(DecodeError::Identifier | DecodeError::Remote) => {
                let (node, message) = FromNode::decode(&frame, layout)?;
                narx_tx_message_t { node: node.raw(), ..message.into() }
            }
            Err(error) => return Err(error.into()),
        };
        pointer::write(message, decoded)
    };
    pointer::status(run())
}

/// Encodes a message as a frame of a bus whose nodes have this layout. Returns NARX_ERROR_NOT_A_MESSAGE if
/// `kind` is no narx_tx_kind_t; NARX_ERROR_FIELD or NARX_ERROR_NODE if a field has an undefined value. Any
/// context; no state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_tx_message_encode(
    message: *const narx_tx_message_t,
    layout: *const narx_tx_layout_t,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let (message, layout) = (pointer::read(message)?, pointer::read(layout)?.try_into()?);
        let encoded = match to_node(message)? {
            Some(to_node) => to_node.encode(),
            None => from_node(message)?.encode(node(message.node)?, layout),
        };
        pointer::write(frame, encoded.into())
    };
    pointer::status(run())
}

/// Returns the message if a master sends it; `None` if a node sends it.
fn to_node(message: &narx_tx_message_t) -> Result<Option<ToNode>, narx_status_t> {
    let &narx_tx_message_t { kind, node: number, command, index, subindex, size, value, .. } = message;
    let sdo = |action| {
        Ok(Some(ToNode::Sdo { node: node(number)?, request: SdoRequest { index, subindex, action } }))
    };
    match kind {
        kind if kind == Kind::Nmt as u8 => {
            let command = NmtCommand::decode(command).ok_or(NARX_ERROR_FIELD)?;
            let target = if number == 0 { Target::All } else { Target::Node(node(number)?) };
            Ok(Some(ToNode::Nmt { command, target }))
        }
        kind if kind == Kind::Sync as u8 => Ok(Some(ToNode::Sync)),
        kind if kind == Kind::RequestPdo as u8 && size <= 8 => {
            Ok(Some(ToNode::RequestPdo { node: node(number)?, bytes: size }))
        }
        kind if kind == Kind::Read as u8 => sdo(SdoAction::Read),
        kind if kind == Kind::Write as u8 && size <= 4 => {
            let size = if size == 0 { None } else { Some(size) };
            sdo(SdoAction::Write { size, data: value.to_le_bytes() })
        }
        kind if kind == Kind::Abort as u8 && message.from_node == 0 => sdo(SdoAction::Abort { code: value }),
        kind if kind == Kind::RequestPdo as u8 || kind == Kind::Write as u8 => Err(NARX_ERROR_FIELD),
        _ => Ok(None),
    }
}

fn from_node(message: &narx_tx_message_t) -> Result<FromNode, narx_status_t> {
    let &narx_tx_message_t { kind, command, index, subindex, size, value, positions, encoder, .. } = message;
    let sdo = |outcome| Ok(FromNode::Sdo(SdoAnswer { index, subindex, outcome }));
    match kind {
        kind if kind == Kind::Heartbeat as u8 => {
            Ok(FromNode::Heartbeat(NmtState::decode(command).ok_or(NARX_ERROR_FIELD)?))
        }
        kind if kind == Kind::Error as u8 => {
            Ok(FromNode::Error { code: u16::try_from(value).map_err(|_| NARX_ERROR_FIELD)? })
        }
        kind if kind == Kind::Pdo as u8 => {
            let kinds = [PdoKind::Timer, PdoKind::Sync, PdoKind::Remote];
            let kind = kinds.into_iter().find(|kind| *kind as u8 == command).ok_or(NARX_ERROR_FIELD)?;
            let positions = positions.map(Position::from_raw);
            Ok(FromNode::Pdo { kind, reading: Reading { positions, encoder } })
        }
        kind if kind == Kind::Written as u8 => sdo(SdoOutcome::Written),
        kind if kind == Kind::Value as u8 => {
            let fits = |bits: u32| value >> bits == 0;
            sdo(SdoOutcome::Value(match size {
                1 if fits(8) => SdoValue::byte(value as u8),
                2 if fits(16) => SdoValue::word(value as u16),
                4 => SdoValue::long(value),
                _ => return Err(NARX_ERROR_FIELD),
            }))
        }
        kind if kind == Kind::Abort as u8 => sdo(SdoOutcome::Aborted { code: value }),
        _ => Err(NARX_ERROR_NOT_A_MESSAGE),
    }
}

/// Returns a message of this kind whose other fields are 0.
const fn empty(kind: Kind) -> narx_tx_message_t {
    narx_tx_message_t {
        kind: kind as u8,
        node: 0,
        command: 0,
        subindex: 0,
        index: 0,
        encoder: 0,
        size: 0,
        from_node: 0,
        value: 0,
        positions: [0; 2],
    }
}

impl TryFrom<ToNode> for narx_tx_message_t {
    type Error = narx_status_t;

    fn try_from(message: ToNode) -> Result<Self, narx_status_t> {
        Ok(match message {
            ToNode::Nmt { command, target } => {
                let node = match target {
                    Target::All => 0,
                    Target::Node(node) => node.raw(),
                };
                Self { node, command: command as u8, ..empty(Kind::Nmt) }
            }
            ToNode::Sync => empty(Kind::Sync),
            ToNode::RequestPdo { node, bytes } => {
                Self { node: node.raw(), size: bytes, ..empty(Kind::RequestPdo) }
            }
            ToNode::Sdo { node, request: SdoRequest { index, subindex, action } } => {
                let (kind, size, value) = match action {
                    SdoAction::Read => (Kind::Read, 0, 0),
                    SdoAction::Write { size, data } => {
                        (Kind::Write, size.unwrap_or(0), u32::from_le_bytes(data))
                    }
                    SdoAction::Abort { code } => (Kind::Abort, 0, code),
                    SdoAction::Unknown { .. } => return Err(NARX_ERROR_FIELD),
                };
                Self { node: node.raw(), index, subindex, size, value, ..empty(kind) }
            }
        })
    }
}

impl From<FromNode> for narx_tx_message_t {
    fn from(message: FromNode) -> Self {
        match message {
            FromNode::Error { code } => Self { value: code.into(), ..empty(Kind::Error) },
            FromNode::Pdo { kind, reading: Reading { positions, encoder } } => Self {
                command: kind as u8,
                positions: positions.map(Position::raw),
                encoder,
                ..empty(Kind::Pdo)
            },
            FromNode::Heartbeat(state) => Self { command: state as u8, ..empty(Kind::Heartbeat) },
            FromNode::Sdo(SdoAnswer { index, subindex, outcome }) => {
                let (kind, size, value) = match outcome {
                    SdoOutcome::Written => (Kind::Written, 0, 0),
                    SdoOutcome::Value(value) => (Kind::Value, value.size(), value.number()),
                    SdoOutcome::Aborted { code } => (Kind::Abort, 0, code),
                };
                let from_node = u8::from(kind == Kind::Abort);
                Self { index, subindex, size, value, from_node, ..empty(kind) }
            }
        }
    }
}

impl TryFrom<&narx_tx_layout_t> for Layout {
    type Error = narx_status_t;

    fn try_from(layout: &narx_tx_layout_t) -> Result<Self, narx_status_t> {
        let channels = match layout.channels {
            1 => Channels::Single,
            2 => Channels::Dual,
            _ => return Err(NARX_ERROR_VARIANT),
        };
        Ok(Self { channels, encoder: layout.encoder != 0 })
    }
}

impl From<Layout> for narx_tx_layout_t {
    fn from(Layout { channels, encoder }: Layout) -> Self {
        let channels = match channels {
            Channels::Single => 1,
            Channels::Dual => 2,
        };
        Self { channels, encoder: encoder.into() }
    }
}

impl From<DecodeError> for narx_status_t {
    fn from(error: DecodeError) -> Self {
        match error {
            DecodeError::Value | DecodeError::NmtCommand(_) => NARX_ERROR_FIELD,
            DecodeError::ExtendedId | DecodeError::Identifier | DecodeError::Remote | DecodeError::Length => {
                NARX_ERROR_NOT_A_MESSAGE
            }
        }
    }
}
