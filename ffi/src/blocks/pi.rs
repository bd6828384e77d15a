//! Proportional-integral controller.

use super::{init, narx_setting_error_t};
use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t;
use narx_core::blocks::{Pi, PiSettings, SettingError};
use narx_core::motor::gain::Gain;

/// A PI controller: memory that the caller owns. It may be copied and moved between calls.
#[repr(C)]
pub struct narx_pi_t {
    /// Private.
    words: [u64; 5],
}

const _: () = handle::assert_fits::<narx_pi_t>();

impl Handle for narx_pi_t {
    type Object = Pi;
    const MARK: u32 = u32::from_be_bytes(*b"nxPI");
}

/// A factor: `mantissa` x 2^-`shift`. A gain in IQ24 is {gain, 24}, one in Q15 {gain, 15}.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_gain_t {
    /// 0 to 2^30 - 1.
    pub mantissa: i32,
    /// Fraction bits, 0 to 62.
    pub shift: u8,
}

/// Settings of a narx_pi_t. Errors and outputs are Q16 in units of your choice.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_pi_settings_t {
    /// Kp: output per error.
    pub proportional: narx_gain_t,
    /// Ki: output per error and second.
    pub integral: narx_gain_t,
    /// Steps a second, 1 to 1 000 000 Hz.
    pub step_rate: u32,
    /// Least output, Q16.
    pub minimum: i32,
    /// Largest output, Q16, not below the least.
    pub maximum: i32,
}

/// Makes a controller at rest: its integrator is 0. Returns NARX_ERROR_SETTING if it cannot be built from the
/// settings; `error`, which may be NULL, then names the setting. Not for an interrupt: it divides.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_pi_init(
    pi: *mut narx_pi_t,
    size: usize,
    settings: *const narx_pi_settings_t,
    error: *mut narx_setting_error_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    match unsafe { pointer::read(settings) } {
        Ok(settings) => unsafe { init(pi, size, error, || build(settings)) },
        Err(error) => error,
    }
}

/// Writes the output for an error, both Q16: u = Kp e + integral of Ki e dt, within its limits. The
/// integrator never holds more than brings the output to a limit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_pi_step(pi: *mut narx_pi_t, error: i32, output: *mut i32) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(output)?;
        pointer::write(output, handle::object(pi)?.step(error))
    };
    pointer::status(run())
}

/// Follows the output `applied` (Q16) that something else decided in this step, whose error was `error`. The
/// integrator goes an eighth of the way to the value that would have given `applied`, so that the controller
/// takes over again without a bump.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_pi_track(pi: *mut narx_pi_t, applied: i32, error: i32) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(pi) }.map(|pi| pi.track(applied, error)))
}

/// Sets the integrator so that it alone gives `output` (Q16).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_pi_hold(pi: *mut narx_pi_t, output: i32) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(pi) }.map(|pi| pi.hold(output)))
}

fn build(settings: &narx_pi_settings_t) -> Result<Pi, SettingError> {
    Pi::build(&PiSettings {
        proportional: gain("proportional", settings.proportional)?,
        integral: gain("integral", settings.integral)?,
        step_rate: settings.step_rate,
        minimum: settings.minimum,
        maximum: settings.maximum,
    })
}

/// Converts a gain to that of the core, or returns its part that is out of range.
fn gain(setting: &'static str, gain: narx_gain_t) -> Result<Gain, SettingError> {
    Gain::new(gain.mantissa, gain.shift).ok_or_else(|| {
        let (value, max) = match gain.shift {
            0..=62 => (gain.mantissa, Gain::MANTISSA_MAX),
            shift => (shift.into(), 62),
        };
        SettingError { setting, value: value.into(), min: 0, max: max.into(), fraction_bits: 0, unit: "" }
    })
}
