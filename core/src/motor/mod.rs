//! The control tick, one file a station, in the order the data flows.

pub mod coefficients;
pub mod commutation;
pub mod event;
pub mod fault;
pub mod front_end;
pub mod pwm;
pub mod samples;
pub mod state;

pub use commutation::{Direction, Leg, Step};
pub use front_end::{Board, Channel, FrontEnd};
pub use pwm::{Commutation, Commutations, PwmCommand, Rectification};
pub use samples::{CurrentMode, Edge, EdgeSource, Lines, SampleMode, Samples};
