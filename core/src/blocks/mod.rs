//! The stations of the drive, one by one: for teaching, for tests, and for a driver of one's own that wants
//! one part of this one.
//!
//! A block is a station of [`motor`](crate::motor) together with its coefficients. Its settings are
//! engineering figures; `build` checks them, and an error names the setting, its value and its range. That
//! takes more flash than the station: `new` takes coefficients that were built elsewhere, as `ready` shows
//! them. `step` cannot fail. It calls the very station that the drive calls, so a block answers what a drive
//! with the same figures answers, bit for bit.
//!
//! ```text
//!  codes, edges ----> Hall ----------+                             voltages, currents, lines
//!                                    +--> position --> Commutation            |
//!  terminals, step -> ZeroCrossing --+     (angle,      -> step, changes    Fault --> fault word
//!                                           speed)                            | critical
//!  set-point -> Ramp -> error -> Pi -> voltage                     request -> StateMachine --> state
//! ```
//!
//! Quantities are raw I16F16 (1 is 65 536) of the unit that is named, angles u32 turns (2^32 is a turn),
//! speeds of a [`Position`] 2^-32 turn a tick, ages 1/65 536 tick. A block is called once a tick.

mod commutation;
#[cfg(feature = "engineering")]
pub mod engineering;
mod error;
mod fault;
mod hall;
mod pi;
mod ramp;
mod state;
mod zero_crossing;

pub use crate::motor::rotor::Position;
pub use commutation::{Commutation, CommutationSettings};
pub use error::SettingError;
pub use fault::{Fault, FaultSettings};
pub use hall::{Hall, HallReading, HallReady, HallSettings};
pub use pi::{Pi, PiReady, PiSettings};
pub use ramp::{Ramp, RampReady, RampSettings};
pub use state::{StateMachine, StateSettings};
pub use zero_crossing::{ZeroCrossing, ZeroCrossingReading, ZeroCrossingReady, ZeroCrossingSettings};

use crate::dictionary::{Parameter, ROWS};
use crate::motor::gain::Gain;
use crate::units::Volts;
use error::within;

/// Row of a parameter. Looked up by the compiler, so that no program carries the table for a default.
const fn row(number: u16) -> &'static Parameter {
    let mut index = 0;
    while ROWS[index].number != number {
        index += 1;
    }
    &ROWS[index]
}

/// Raw factory value of a parameter: defaults are the drive's.
const fn factory(number: u16) -> u32 {
    row(number).factory_raw() as u32
}

/// Factory value of a parameter as a quantity in its unit, raw I16F16.
const fn factory_quantity(number: u16) -> i32 {
    let row = row(number);
    Volts::from_ratio(row.factory_raw() as i64, 10_i32.pow((-row.exponent) as u32)).to_bits()
}

/// The control rates that a board may have, ticks a second: those of [`Board`](crate::motor::Board).
fn tick_rate(rate: u32) -> Result<u32, SettingError> {
    within("tick_rate", rate.into(), 1_000, 100_000, "Hz").map(|_| rate)
}

/// Ticks in this many milliseconds, at least 1.
fn ticks(milliseconds: u32, rate: u32) -> u32 {
    (u64::from(milliseconds) * u64::from(rate) / 1000).clamp(1, u32::MAX.into()) as u32
}

/// Gain from 2^-32 turn a tick to raw I16F16 rev/s.
fn speed_of_turns(rate: u32) -> Gain {
    Gain::from_ratio(rate.into(), 65_536).unwrap_or(Gain::ZERO)
}

/// Gain from raw I16F16 rev/s to 2^-32 turn a tick.
fn turns_of_speed(rate: u32) -> Gain {
    Gain::from_ratio(65_536, rate.into()).unwrap_or(Gain::ZERO)
}

/// Converts an angle in 0.01 degree to a u32 turn.
const fn turn_of_centidegrees(angle: i32) -> u32 {
    (((angle as i64) << 32) / 36_000) as u32
}
