//! The eddyCAN wire format of TX-Drivers (eddyCAN specification, section 3): 11-bit identifiers of a function
//! and a node-id, little endian. Both directions have an encoder and a decoder, so device, master and log
//! reader share one code.

mod bitrate;
mod error;
mod id;
mod message;
mod nmt;
mod pdo;
mod sdo;

pub use bitrate::Bitrate;
pub use error::{DecodeError, ErrorCode};
pub use id::{CobId, IDENTIFIERS, Identifier, NodeId, PdoKind};
pub use message::{FromNode, ToNode};
pub use nmt::{NmtCommand, NmtState, Target};
pub use pdo::{Channels, Layout, Position, Reading};
pub use sdo::{AbortCode, SdoAction, SdoAnswer, SdoOutcome, SdoRequest, SdoValue};
