//! CAN frames and the wire formats: bytes to meaning and back, nothing else.

pub mod frame;
pub mod narmotion;

pub use frame::{Frame, Id};
