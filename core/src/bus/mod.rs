//! CAN frames and the wire formats: bytes to meaning and back, nothing else.

pub mod candump;
mod confinement;
pub mod eddycan;
pub mod frame;
pub mod narmotion;
pub mod slcan;

pub use confinement::{BusState, ErrorState};
pub use frame::{Frame, Id};
