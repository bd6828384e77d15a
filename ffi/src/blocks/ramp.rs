//! Rate limit of a set-point.

use super::{init, init_ready, narx_ramp_settings_t, narx_setting_error_t};
use crate::handle::{self, Handle};
use crate::pointer;
use crate::status::narx_status_t;
use narx_core::blocks::{Ramp, RampReady};

/// A ramp: memory that the caller owns. It may be copied and moved between calls.
#[repr(C)]
pub struct narx_ramp_t {
    /// Private.
    words: [u64; 3],
}

const _: () = handle::assert_fits::<narx_ramp_t>();

impl Handle for narx_ramp_t {
    type Object = Ramp;
    const MARK: u32 = u32::from_be_bytes(*b"nxRa");
}

/// Makes a ramp at 0. Returns NARX_ERROR_SETTING if it cannot be built from the settings; `error`, which may
/// be NULL, then names the setting. Not for an interrupt: it divides.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_ramp_init(
    ramp: *mut narx_ramp_t,
    size: usize,
    settings: *const narx_ramp_settings_t,
    error: *mut narx_setting_error_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init(ramp, size, settings, error, Ramp::build) }
}

/// Makes a ramp at 0 from ready-made coefficients: what narx has computed on the desk from such settings as
/// narx_ramp_init takes. They are not checked. It takes a few hundred bytes of flash where narx_ramp_init
/// takes thousands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_ramp_init_ready(
    ramp: *mut narx_ramp_t,
    size: usize,
    ready: *const RampReady,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init_ready(ramp, size, ready, |ready| Ramp::new(*ready)) }
}

/// Moves one step towards `target` and writes the new value to `value`, both Q16.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_ramp_step(
    ramp: *mut narx_ramp_t,
    target: i32,
    value: *mut i32,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(value)?;
        pointer::write(value, handle::object(ramp)?.step(target))
    };
    pointer::status(run())
}

/// Continues from `value`, Q16.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_ramp_set(ramp: *mut narx_ramp_t, value: i32) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(ramp) }.map(|ramp| ramp.set(value)))
}
