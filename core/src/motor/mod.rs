//! The control tick, one file a station. `drive` calls them in the order the data flows:
//!
//! ```text
//! samples -> measurement -> rotor (hall | back_emf, zero_crossing, listening, sensorless | open_loop)
//!         -> protection (rails, fault) -> machine (state)
//!         -> control (pi, ramp, limits) -> commutator (commutation) -> pwm
//! ```

pub mod drive;

pub mod samples;

pub mod measurement;

pub mod back_emf;
pub mod listening;
pub mod zero_crossing;

pub mod hall;
pub mod hall_calibration;
pub mod interval;
pub mod open_loop;
pub mod rotor;
pub mod sensorless;

pub mod fault;
pub mod open_phase;
pub mod protection;
pub mod rails;

pub mod machine;
pub mod state;

pub mod band;
pub mod control;
pub mod gain;
pub mod limits;
pub mod pi;
pub mod ramp;

pub mod commutation;
pub mod commutator;
pub mod pwm;

pub mod coefficients;
pub mod event;
pub mod front_end;
pub mod signal;

pub use coefficients::{BuildError, Coefficients};
pub use commutation::{Direction, Leg, Step};
pub use drive::Drive;
pub use event::{Command, Event, Request, Status};
pub use fault::{Cause, FaultWord};
pub use front_end::{Board, Channel, Equipment, FrontEnd};
pub use pwm::{Commutation, Commutations, PwmCommand, Rectification};
pub use samples::{CurrentMode, Edge, EdgeSource, Lines, SampleMode, Samples};
pub use state::State;
