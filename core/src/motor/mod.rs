//! The control tick. Each station has its folder, and `drive` calls them in the order the data flows:
//!
//! ```text
//! samples -> sense (measurement) -> rotor (hall | sensorless: back_emf, zero_crossing, listening | open_loop)
//!         -> guard (protection, fault, open_phase, rails) -> machine (state)
//!         -> commutate (commutator, commutation) -> control (limits, pi, steady)
//!         -> commutate (pulses, pwm)
//! ```

pub mod drive;

pub mod commutate;
pub mod control;
pub mod guard;
pub mod machine;
pub mod rotor;
pub mod sense;

pub mod band;
pub mod clock;
pub mod coefficients;
pub mod gain;
pub mod interval;
pub mod modes;
pub mod ramp;
pub mod signal;

pub use coefficients::{BuildError, Coefficients};
pub use commutate::commutation::{Direction, Leg, Step};
pub use commutate::pwm::{Commutation, Commutations, PwmCommand, Rectification};
pub use drive::Drive;
pub use guard::fault::{Cause, FaultWord};
pub use machine::event::{Command, Event, RunRequest, Status};
pub use machine::state::State;
pub use sense::front_end::{Board, Channel, Equipment, FrontEnd};
pub use sense::samples::{CurrentMode, Edge, EdgeSource, Lines, SampleMode, Samples};
