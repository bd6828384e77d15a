//! The NarMotion-X wire format (Annex A of the specification): 29-bit identifiers, frames of four 16-bit
//! words, big endian. 32-bit values are high word first. Both directions have an encoder and a decoder, so
//! device, master, simulator and log reader share one code.

mod from_drive;
mod id;
mod measurement;
mod message;
mod signal;
mod to_drive;
#[cfg(feature = "update")]
pub mod update;
mod word;
mod words;

pub(crate) use from_drive::Addressless;
pub use from_drive::{FromDrive, ParameterStatus};
pub use id::{Addresses, MessageId, MessageKind, Opcode, Priority};
pub use measurement::Measurement;
pub use message::{Field, MESSAGES, Meaning, Message, NAMES, Names};
pub use signal::{SIGNALS, Signal};
pub use to_drive::{DigitalOutputs, ToDrive, XmlCommand};
pub use word::{ControlMode, MotorMode, RequestWord, StatusWord};
pub use words::{DecodeError, Words};
