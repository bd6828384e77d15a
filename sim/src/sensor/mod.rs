//! Sensors beside a shaft: eddy-current sensors, whose target moves with it, and an incremental encoder.
//!
//! ```text
//!  shaft ──> target (run-out, axial play, screw) ──> distance ──> noise, ends of the range, quantisation ──> position
//!    └────> encoder ──> counts
//! ```
//!
//! The specification prints nothing of sensors but that they have a measuring range: noise and motions are
//! our estimates.

mod eddy_current;
mod encoder;
mod target;

pub use eddy_current::{EddyCurrent, EddyCurrentConfig, SensorError};
pub use encoder::Encoder;
pub use target::{AxialPlay, Harmonic, Target};

/// A shaft at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaft {
    /// Mechanical angle, revolutions, unwrapped.
    pub turns: f64,
    /// Mechanical speed, rad/s.
    pub speed: f64,
}
