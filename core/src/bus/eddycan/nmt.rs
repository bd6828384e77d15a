//! Network management: commands (Figure 8, Table 11) and the states that heartbeats tell (Table 12).

use super::error::DecodeError;
use super::id::NodeId;

/// NMT command: a state to enter, or a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum NmtCommand {
    /// 01h: Operational.
    Start = 0x01,
    /// 02h: Stopped.
    Stop = 0x02,
    /// 80h: Pre-Operational.
    PreOperational = 0x80,
    /// 81h: restart.
    Reset = 0x81,
}

/// Receiver of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// 0: every node.
    All,
    /// 1..=127: this one.
    Node(NodeId),
}

/// State in a heartbeat.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum NmtState {
    /// 0: the node has just started; sent once.
    BootUp = 0,
    /// 4: neither SDO nor PDO.
    Stopped = 4,
    /// 5: PDO, and no SDO.
    Operational = 5,
    /// 7Fh: SDO, and no PDO.
    PreOperational = 0x7F,
}

impl NmtCommand {
    /// Every command in the order of Table 11.
    pub const ALL: [Self; 4] = [Self::Start, Self::Stop, Self::PreOperational, Self::Reset];

    /// The command of a byte, if Table 11 lists it.
    pub fn decode(byte: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|command| *command as u8 == byte)
    }
}

impl Target {
    pub(super) const fn encode(self) -> u8 {
        match self {
            Self::All => 0,
            Self::Node(node) => node.raw(),
        }
    }

    pub(super) const fn decode(byte: u8) -> Result<Self, DecodeError> {
        match NodeId::new(byte) {
            Some(node) => Ok(Self::Node(node)),
            None if byte == 0 => Ok(Self::All),
            None => Err(DecodeError::Value),
        }
    }

    /// Returns whether the command is for this node.
    pub fn includes(self, node: NodeId) -> bool {
        self == Self::All || self == Self::Node(node)
    }
}

impl NmtState {
    /// Every state in the order of Table 12.
    pub const ALL: [Self; 4] = [Self::BootUp, Self::Stopped, Self::Operational, Self::PreOperational];

    /// The state of a byte, if Table 12 lists it.
    pub fn decode(byte: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|state| *state as u8 == byte)
    }
}
