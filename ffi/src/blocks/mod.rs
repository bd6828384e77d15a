//! The drive's blocks, one by one, in the caller's memory.

mod commutation;
pub(crate) mod fault;
mod gain;
mod hall;
mod pi;
mod ramp;
#[rustfmt::skip]
mod settings;
mod state;
mod zero_crossing;

pub use commutation::*;
pub use fault::*;
pub use hall::*;
pub use pi::*;
pub use ramp::*;
pub use settings::*;
pub use state::*;
pub use zero_crossing::*;

use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use core::ffi::c_char;
use narx_core::blocks::SettingError;
use narx_core::motor::Direction;

/// Size of the name and the unit of a setting in narx_setting_error_t, the closing 0 included.
pub const NARX_NAME_SIZE: usize = 24;

/// A setting from which no block can be built.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_setting_error_t {
    /// The rejected value.
    pub value: i64,
    /// Smallest value that builds, with the other settings as they are.
    pub min: i64,
    /// Largest value that builds.
    pub max: i64,
    /// Fraction bits of the three values: 16 for a Q16, 0 for a count.
    pub fraction_bits: u8,
    /// Name of the setting: the name of its field.
    pub setting: [c_char; NARX_NAME_SIZE],
    /// Its unit, empty without one.
    pub unit: [c_char; NARX_NAME_SIZE],
}

/// Builds a block from `settings` into `size` bytes of memory; on an error of the settings writes that to
/// `error`, unless it is NULL.
///
/// # Safety
/// The rule for pointers at the head of narx.h.
unsafe fn init<H: Handle, Given, Settings>(
    memory: *mut H,
    size: usize,
    settings: *const Given,
    error: *mut narx_setting_error_t,
    build: impl FnOnce(&Settings) -> Result<H::Object, SettingError>,
) -> narx_status_t
where
    Settings: for<'a> TryFrom<&'a Given, Error = SettingError>,
{
    let object = || {
        // SAFETY: the caller's promise.
        let settings = unsafe { pointer::read(settings)? };
        settings.try_into().and_then(|settings| build(&settings)).map_err(|reason| {
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

/// Makes a block with ready-made coefficients in `size` bytes of memory.
///
/// # Safety
/// The rule for pointers at the head of narx.h.
unsafe fn init_ready<H: Handle, Ready>(
    memory: *mut H,
    size: usize,
    ready: *const Ready,
    new: impl FnOnce(&Ready) -> H::Object,
) -> narx_status_t {
    // SAFETY: the caller's promise.
    pointer::status(unsafe { handle::init_from(memory, size, ready, new) })
}

/// Returns the direction with this number: 0 forward, 1 reverse.
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

/// Returns the text with a closing 0, cut to the size of the field.
fn name(text: &str) -> [c_char; NARX_NAME_SIZE] {
    let mut name = [0; NARX_NAME_SIZE];
    for (to, from) in name.iter_mut().take(NARX_NAME_SIZE - 1).zip(text.bytes()) {
        *to = from as c_char;
    }
    name
}
