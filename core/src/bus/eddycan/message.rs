//! Whole frames, by direction.

use super::error::DecodeError;
use super::id::{CobId, NodeId, PdoKind};
use super::nmt::{NmtCommand, NmtState, Target};
use super::pdo::{Layout, Reading};
use super::sdo::{SdoAnswer, SdoRequest};
use crate::bus::Frame;

/// Message of a master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToNode {
    /// NMT: command to one node or all.
    Nmt {
        /// State to enter, or restart.
        command: NmtCommand,
        /// Addressed nodes.
        target: Target,
    },
    /// SYNC.
    Sync,
    /// The remote frame that asks for PDO3.
    RequestPdo {
        /// Addressed node.
        node: NodeId,
        /// Number of requested bytes, 0..=8.
        bytes: u8,
    },
    /// SDO to a node.
    Sdo {
        /// Addressed node.
        node: NodeId,
        /// Request for one entry.
        request: SdoRequest,
    },
}

/// Message of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FromNode {
    /// Error message. [`super::ErrorCode::decode`] knows the codes of Table 13.
    Error {
        /// Its code.
        code: u16,
    },
    /// PDO1, PDO2 or PDO3.
    Pdo {
        /// Trigger of the PDO.
        kind: PdoKind,
        /// Readings in the PDO.
        reading: Reading,
    },
    /// Answer to an SDO.
    Sdo(SdoAnswer),
    /// Boot-up or heartbeat.
    Heartbeat(NmtState),
}

impl ToNode {
    /// The frame, as the master sends it; a request for more than 8 bytes becomes one for 8.
    pub fn encode(self) -> Frame {
        match self {
            Self::Nmt { command, target } => {
                Frame::short(CobId::Nmt.encode(), [command as u8, target.encode(), 0, 0, 0, 0, 0, 0], 2)
            }
            Self::Sync => Frame::short(CobId::Sync.encode(), [0; 8], 0),
            Self::RequestPdo { node, bytes } => {
                Frame::remote_clamped(CobId::Pdo(PdoKind::Remote, node).encode(), bytes)
            }
            Self::Sdo { node, request } => Frame::full(CobId::SdoRequest(node).encode(), request.encode()),
        }
    }

    /// Decodes a frame.
    ///
    /// # Errors
    /// The frame is malformed, or no message of a master.
    pub fn decode(frame: &Frame) -> Result<Self, DecodeError> {
        let id = CobId::decode(frame.id())?;
        if frame.is_remote() {
            return match id {
                CobId::Pdo(PdoKind::Remote, node) => Ok(Self::RequestPdo { node, bytes: frame.dlc() }),
                _ => Err(DecodeError::Remote),
            };
        }
        match (id, frame.payload()) {
            (CobId::Nmt, &[command, target]) => {
                let target = Target::decode(target)?;
                let command = NmtCommand::decode(command).ok_or(DecodeError::NmtCommand(target))?;
                Ok(Self::Nmt { command, target })
            }
            (CobId::Sync, []) => Ok(Self::Sync),
            (CobId::SdoRequest(node), _) => {
                let data = frame.full_payload().ok_or(DecodeError::Length)?;
                Ok(Self::Sdo { node, request: SdoRequest::decode(data) })
            }
            (CobId::Nmt | CobId::Sync, _) => Err(DecodeError::Length),
            _ => Err(DecodeError::Identifier),
        }
    }
}

impl FromNode {
    /// The frame, as the node sends it.
    pub fn encode(self, node: NodeId, layout: Layout) -> Frame {
        match self {
            Self::Error { code } => {
                let [low, high] = code.to_le_bytes();
                Frame::short(CobId::Error(node).encode(), [low, high, 0, 0, 0, 0, 0, 0], 2)
            }
            Self::Pdo { kind, reading } => {
                Frame::short(CobId::Pdo(kind, node).encode(), layout.encode(reading), layout.length())
            }
            Self::Sdo(answer) => Frame::full(CobId::SdoAnswer(node).encode(), answer.encode()),
            Self::Heartbeat(state) => {
                Frame::short(CobId::Heartbeat(node).encode(), [state as u8, 0, 0, 0, 0, 0, 0, 0], 1)
            }
        }
    }

    /// Decodes a frame of a node with this layout; returns the node-id and the message. An error message may
    /// be longer than its two bytes, as those of CANopen nodes are.
    ///
    /// # Errors
    /// The frame is malformed, or no message of such a node.
    pub fn decode(frame: &Frame, layout: Layout) -> Result<(NodeId, Self), DecodeError> {
        let id = CobId::decode(frame.id())?;
        if frame.is_remote() {
            return Err(DecodeError::Remote);
        }
        match (id, frame.payload()) {
            (CobId::Error(node), &[low, high, ..]) => {
                Ok((node, Self::Error { code: u16::from_le_bytes([low, high]) }))
            }
            (CobId::Pdo(kind, node), data) => {
                let reading = layout.decode(data).ok_or(DecodeError::Length)?;
                Ok((node, Self::Pdo { kind, reading }))
            }
            (CobId::SdoAnswer(node), _) => {
                let data = frame.full_payload().ok_or(DecodeError::Length)?;
                Ok((node, Self::Sdo(SdoAnswer::decode(data).ok_or(DecodeError::Value)?)))
            }
            (CobId::Heartbeat(node), &[state]) => {
                Ok((node, Self::Heartbeat(NmtState::decode(state).ok_or(DecodeError::Value)?)))
            }
            (CobId::Error(_) | CobId::Heartbeat(_), _) => Err(DecodeError::Length),
            _ => Err(DecodeError::Identifier),
        }
    }
}
