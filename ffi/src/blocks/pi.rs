//! Proportional-integral controller.

use super::{init, init_ready, narx_pi_settings_t, narx_setting_error_t};
use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t;
use narx_core::blocks::{Pi, PiReady};

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
    unsafe { init(pi, size, settings, error, Pi::build) }
}

/// Makes a controller at rest from ready-made coefficients: what narx has computed on the desk from such
/// settings as narx_pi_init takes. They are not checked. It takes a few hundred bytes of flash where
/// narx_pi_init takes thousands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_pi_init_ready(
    pi: *mut narx_pi_t,
    size: usize,
    ready: *const PiReady,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init_ready(pi, size, ready, |ready| Pi::new(*ready)) }
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
