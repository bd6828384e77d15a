//! CAN frames and the two wire formats: bytes to meaning and back, nothing else.
pub mod frame;
pub use frame::{Frame, Id};
