//! The stations of the drive, one by one, in the caller's memory.

mod commutation;
mod fault;
mod hall;
mod pi;
mod ramp;
mod state;
mod zero_crossing;

pub use commutation::*;
pub use fault::*;
pub use hall::*;
pub use pi::*;
pub use ramp::*;
pub use state::*;
pub use zero_crossing::*;

use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use core::ffi::c_char;
use narx_core::blocks::SettingError;
use narx_core::motor::Direction;

/// Room for the name and the unit of a setting, the closing 0 included.
pub const NARX_NAME_SIZE: usize = 24;

/// A setting that no block can be built from.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_setting_error_t {
    /// What it was.
    pub value: i64,
    /// Smallest value that builds, with the other settings as they are.
    pub min: i64,
    /// Largest value that builds.
    pub max: i64,
    /// Fraction bits of the three: 16 for a Q16, 0 for a count.
    pub fraction_bits: u8,
    /// Name of the setting, as its field is called.
    pub setting: [c_char; NARX_NAME_SIZE],
    /// Its unit, empty without one.
    pub unit: [c_char; NARX_NAME_SIZE],
}

/// Puts a block into `size` bytes of memory, or says what is wrong with its settings where somebody wants to know.
///
/// # Safety
/// The rule for pointers at the head of narx.h.
unsafe fn init<H: Handle>(
    memory: *mut H,
    size: usize,
    error: *mut narx_setting_error_t,
    build: impl FnOnce() -> Result<H::Object, SettingError>,
) -> narx_status_t {
    let object = || {
        build().map_err(|reason| {
            // SAFETY: the caller's promise.
            match unsafe { pointer::write_unless_null(error, reason.into()) } {
                Ok(()) => NARX_ERROR_SETTING,
                Err(error) => error,
            }
        })
    };
    // SAFETY: the caller's promise.
    pointer::status(unsafe { handle::init(memory, size, object) })
}

/// 0 forward, 1 reverse.
fn direction(number: u8) -> Result<Direction, narx_status_t> {
    match number {
        0 => Ok(Direction::Forward),
        1 => Ok(Direction::Reverse),
        _ => Err(NARX_ERROR_ARGUMENT),
    }
}

impl From<SettingError> for narx_setting_error_t {
    fn from(SettingError { setting, value, min, max, fraction_bits, unit }: SettingError) -> Self {
        Self { value, min, max, fraction_bits, setting: name(setting), unit: name(unit) }
    }
}

/// The text, cut where the room ends, and a closing 0.
fn name(text: &str) -> [c_char; NARX_NAME_SIZE] {
    let mut name = [0; NARX_NAME_SIZE];
    for (to, from) in name.iter_mut().take(NARX_NAME_SIZE - 1).zip(text.bytes()) {
        *to = from as c_char;
    }
    name
}
