//! The 11-bit identifier (Table 3).
//!
//! ```text
//!  bit   10 .. 7  | 6 .. 0
//!        function | node-id
//! ```

use super::error::DecodeError;
use crate::bus::Id;
use serde::{Deserialize, Serialize};

/// A node-id, 1..=127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(try_from = "u8", into = "u8")]
pub struct NodeId(u8);

/// Meaning of an identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CobId {
    /// 0: network management; the data names the receiver.
    Nmt,
    /// 80h: synchronisation, to everybody.
    Sync,
    /// 80h + node-id: an error of the node.
    Error(NodeId),
    /// 180h, 280h or 380h + node-id: positions of the node, or the remote request for them.
    Pdo(PdoKind, NodeId),
    /// 580h + node-id: the node answers.
    SdoAnswer(NodeId),
    /// 600h + node-id: the node is asked.
    SdoRequest(NodeId),
    /// 700h + node-id: the node is alive.
    Heartbeat(NodeId),
}

/// Trigger of a process data object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum PdoKind {
    /// PDO1: the node's own clock.
    Timer = 1,
    /// PDO2: a SYNC message.
    Sync = 2,
    /// PDO3: a remote frame.
    Remote = 3,
}

/// One row of Table 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identifier {
    /// Name as printed.
    pub name: &'static str,
    /// The identifier for node-id 0.
    pub base: u16,
    /// The node-id is added to it.
    pub node: bool,
    /// A node sends it, or else the master.
    pub from_node: bool,
    /// Purpose of the identifier.
    pub purpose: &'static str,
}

/// Table 3 in its order, which is that of the priorities.
pub const IDENTIFIERS: [Identifier; 9] = [
    row("NMT", 0, false, false, "state of one node or of all"),
    row("SYNC", 0x80, false, false, "all nodes sample now and send PDO2"),
    row("Error", 0x80, true, true, "an error has occurred"),
    row("PDO1", 0x180, true, true, "positions by the node's clock"),
    row("PDO2", 0x280, true, true, "positions at a SYNC"),
    row(
        "PDO3",
        0x380,
        true,
        true,
        "positions at a remote frame, which the master sends with the same identifier",
    ),
    row("SDO answer", 0x580, true, true, "confirmation, value or abort"),
    row("SDO request", 0x600, true, false, "read or write of an entry"),
    row("Heartbeat", 0x700, true, true, "boot-up, and the state every 2 s"),
];

const fn row(
    name: &'static str,
    base: u16,
    node: bool,
    from_node: bool,
    purpose: &'static str,
) -> Identifier {
    Identifier { name, base, node, from_node, purpose }
}

impl NodeId {
    /// As shipped: 1.
    pub const FACTORY: Self = Self(1);

    /// A node-id, or `None` for 0 and above 127.
    pub const fn new(raw: u8) -> Option<Self> {
        if matches!(raw, 1..=127) { Some(Self(raw)) } else { None }
    }

    /// The number, 1..=127.
    pub const fn raw(self) -> u8 {
        self.0
    }
}

impl TryFrom<u8> for NodeId {
    type Error = DecodeError;

    fn try_from(raw: u8) -> Result<Self, DecodeError> {
        Self::new(raw).ok_or(DecodeError::Value)
    }
}

impl From<NodeId> for u8 {
    fn from(node: NodeId) -> Self {
        node.0
    }
}

impl CobId {
    /// The identifier on the bus.
    pub const fn encode(self) -> Id {
        let (base, node) = match self {
            Self::Nmt => (0, 0),
            Self::Sync => (0x80, 0),
            Self::Error(node) => (0x80, node.0),
            Self::Pdo(kind, node) => (0x80 + 0x100 * kind as u16, node.0),
            Self::SdoAnswer(node) => (0x580, node.0),
            Self::SdoRequest(node) => (0x600, node.0),
            Self::Heartbeat(node) => (0x700, node.0),
        };
        Id::standard_masked(base + node as u16)
    }

    /// Decodes an identifier.
    ///
    /// # Errors
    /// A 29-bit identifier, or one that Table 3 does not list.
    pub const fn decode(id: Id) -> Result<Self, DecodeError> {
        if id.is_extended() {
            return Err(DecodeError::ExtendedId);
        }
        let raw = id.raw();
        let Some(node) = NodeId::new((raw & 0x7F) as u8) else {
            return match raw {
                0 => Ok(Self::Nmt),
                0x80 => Ok(Self::Sync),
                _ => Err(DecodeError::Identifier),
            };
        };
        Ok(match raw & 0x780 {
            0x80 => Self::Error(node),
            0x180 => Self::Pdo(PdoKind::Timer, node),
            0x280 => Self::Pdo(PdoKind::Sync, node),
            0x380 => Self::Pdo(PdoKind::Remote, node),
            0x580 => Self::SdoAnswer(node),
            0x600 => Self::SdoRequest(node),
            0x700 => Self::Heartbeat(node),
            _ => return Err(DecodeError::Identifier),
        })
    }
}
