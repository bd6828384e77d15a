//! Six-step commutation: the table, and the steps for a position.

use super::{direction, init, init_ready, narx_commutation_settings_t, narx_setting_error_t};
use crate::handle::{self, Handle};
use crate::pointer;
use crate::pwm::{self, NARX_COMMUTATIONS_MAX, narx_commutation_t};
use crate::status::narx_status_t::{self, *};
use narx_core::blocks::{Commutation, Position};
use narx_core::motor::commutate::commutator::CommutatorCoefficients;
use narx_core::motor::{Leg, Step};

/// A commutation: memory that the caller owns. It may be copied and moved between calls.
#[repr(C)]
pub struct narx_commutator_t {
    /// Private.
    words: [u64; 4],
}

const _: () = handle::assert_fits::<narx_commutator_t>();

impl Handle for narx_commutator_t {
    type Object = Commutation;
    const MARK: u32 = u32::from_be_bytes(*b"nxCo");
}

/// The steps of one period.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_steps_t {
    /// The step at the earliest instant.
    pub step: Step,
    /// Number of valid entries of `commutations`.
    pub commutation_count: u8,
    /// Changes later in the period, in order of time.
    pub commutations: [narx_commutation_t; NARX_COMMUTATIONS_MAX],
}

/// Writes the step that gives torque in direction `towards` (0 forward, 1 reverse) to a rotor in `sector`, 0
/// to 5. Any context; no state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_commutation_step_for(
    sector: u8,
    towards: u8,
    step: *mut Step,
) -> narx_status_t {
    let run = || {
        let towards = direction(towards)?;
        if sector > 5 {
            return Err(NARX_ERROR_ARGUMENT);
        }
        // SAFETY: the rule for pointers at the head of narx.h.
        unsafe { pointer::write(step, Step::for_sector(sector, towards)) }
    };
    pointer::status(run())
}

/// Writes the action of a step (a narx_step_t) on the legs of phases A, B, C into `legs`, 3 bytes: 0 both
/// switches off, 1 low side on, 2 switched with the duty. Any context; no state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_commutation_legs(step: u8, legs: *mut u8) -> narx_status_t {
    let run = || {
        let step = Step::from_number(step).ok_or(NARX_ERROR_ARGUMENT)?;
        let told = step.legs().map(|leg| match leg {
            Leg::Floating => 0_u8,
            Leg::Low => 1,
            Leg::Switched => 2,
        });
        // SAFETY: the rule for pointers at the head of narx.h.
        unsafe { pointer::write(legs.cast(), told) }
    };
    pointer::status(run())
}

/// Makes a commutation that knows no rotor position yet. Returns NARX_ERROR_SETTING if it cannot be built
/// from the settings; `error`, which may be NULL, then names the setting.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_commutation_init(
    commutation: *mut narx_commutator_t,
    size: usize,
    settings: *const narx_commutation_settings_t,
    error: *mut narx_setting_error_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init(commutation, size, settings, error, Commutation::build) }
}

/// Makes a commutation that knows no rotor position yet from ready-made coefficients: what narx has computed
/// on the desk from such settings as narx_commutation_init takes. They are not checked. It takes a few
/// hundred bytes of flash where narx_commutation_init takes thousands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_commutation_init_ready(
    commutation: *mut narx_commutator_t,
    size: usize,
    ready: *const CommutatorCoefficients,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init_ready(commutation, size, ready, |ready| Commutation::new(*ready)) }
}

/// Writes the steps of this period for a rotor at `angle` (2^32 a turn) that turns with `turn_speed`
/// (2^-32 turn a tick, signed), both at the period's boundary, with torque in direction `towards` (0 forward,
/// 1 reverse). A rotor that seems to have fallen back by less than 15 degrees is not commutated back.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_commutation_step(
    commutation: *mut narx_commutator_t,
    angle: u32,
    turn_speed: i32,
    towards: u8,
    steps: *mut narx_steps_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(steps)?;
        let commutation = handle::object(commutation)?;
        let position = Position { angle, speed: turn_speed };
        let (step, changes) = commutation.step(position, direction(towards)?);
        let (commutation_count, commutations) = pwm::told(changes);
        pointer::write(steps, narx_steps_t { step, commutation_count, commutations })
    };
    pointer::status(run())
}

/// Forgets the sector; call it after the bridge was off.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_commutation_reset(commutation: *mut narx_commutator_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(commutation) }.map(Commutation::reset))
}
