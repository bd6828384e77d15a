//! Zero crossings of the floating phase: angle, speed and the next commutation.

use super::{direction, init, init_ready, narx_setting_error_t, narx_zero_crossing_settings_t};
use crate::handle::{self, Handle};
use crate::pointer;
use crate::pwm::NARX_COMMUTATIONS_MAX;
use crate::samples::narx_samples_t;
use crate::status::narx_status_t::{self, *};
use narx_core::blocks::{ZeroCrossing, ZeroCrossingReading, ZeroCrossingReady, ZeroCrossingSettings};
use narx_core::motor::{Commutation, PwmCommand, Samples, Step};

/// A zero crossing detector with its estimator: memory that the caller owns. It may be copied and moved
/// between calls.
#[repr(C)]
pub struct narx_zero_crossing_t {
    /// Private.
    words: [u64; 38],
}

const _: () = handle::assert_fits::<narx_zero_crossing_t>();

impl Handle for narx_zero_crossing_t {
    type Object = ZeroCrossing;
    const MARK: u32 = u32::from_be_bytes(*b"nxZC");
}

/// The pattern that was applied in the period that has ended.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_applied_t {
    /// Instant at which the phases were sampled, in 1/65 536 of the period.
    pub sample_at: u16,
    /// Step at the period's earliest instant: a narx_step_t.
    pub step: u8,
    /// Number of changes that followed.
    pub commutation_count: u8,
    /// Instants of the changes, in 1/65 536 of the period.
    pub instants: [u16; NARX_COMMUTATIONS_MAX],
    /// Steps after the changes.
    pub steps: [u8; NARX_COMMUTATIONS_MAX],
}

/// Reading of the terminals after a tick.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_zero_crossing_reading_t {
    /// Age of a crossing that was seen in this tick: time from it to the present boundary, 1/65 536 tick,
    /// negative after the boundary; INT32_MIN without one.
    pub crossing: i32,
    /// Time from the present boundary to the next commutation, 1/65 536 tick: 0 is now, UINT32_MAX is
    /// unknown.
    pub commutation: u32,
    /// Electrical angle at the present boundary, 2^32 a turn; for narx_commutation_step.
    pub angle: u32,
    /// Speed, 2^-32 turn a tick, signed; for narx_commutation_step.
    pub turn_speed: i32,
    /// Electrical speed, Q16 rev/s, signed; 0 while unknown.
    pub speed: i32,
    /// Crossings accepted since narx_zero_crossing_init, wrapping.
    pub accepted: u32,
    /// Lag of the last accepted crossing behind its prediction, 65 536 a turn.
    pub margin: i16,
    /// Outcome of the last step's crossing: 0 none yet, 1 accepted, 2 too early, 3 not seen, 4 hidden by
    /// demagnetisation, 5 seen on a coasting motor.
    pub why: u8,
    /// Not 0: six consistent crossings of both polarities; the position may close a loop.
    pub running: u8,
    /// Not 0: the bridge must be switched off: 1 stalled, 2 out of step.
    pub lost: u8,
}

/// Writes default settings, as a start for your own: 10 kHz, narx's own converter, 4 codes of noise, 200 us
/// of blanking, samples, no delays, no advance, 500 ticks; the back-EMF is unknown.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_zero_crossing_settings_default(
    settings: *mut narx_zero_crossing_settings_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { pointer::write(settings, ZeroCrossingSettings::default().into()) })
}

/// Makes a detector that has not seen the motor yet. Returns NARX_ERROR_SETTING if it cannot be built from
/// the settings; `error`, which may be NULL, then names the setting. Not for an interrupt: it divides.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_zero_crossing_init(
    detector: *mut narx_zero_crossing_t,
    size: usize,
    settings: *const narx_zero_crossing_settings_t,
    error: *mut narx_setting_error_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init(detector, size, settings, error, ZeroCrossing::build) }
}

/// Makes a detector that has not seen the motor yet from ready-made coefficients: what narx has computed on
/// the desk from such settings as narx_zero_crossing_init takes. They are not checked. It takes a few hundred
/// bytes of flash where narx_zero_crossing_init takes thousands.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_zero_crossing_init_ready(
    detector: *mut narx_zero_crossing_t,
    size: usize,
    ready: *const ZeroCrossingReady,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    unsafe { init_ready(detector, size, ready, |ready| ZeroCrossing::new(*ready)) }
}

/// Begins to bring up a rotor that rests at `angle` (2^32 a turn), in direction `towards` (0 forward, 1
/// reverse).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_zero_crossing_start(
    detector: *mut narx_zero_crossing_t,
    angle: u32,
    towards: u8,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || {
        let towards = direction(towards)?;
        unsafe { handle::object(detector)? }.start(angle, towards);
        Ok(())
    };
    pointer::status(run())
}

/// Goes on by a step without any evidence: the rotor that is being brought up has not moved.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_zero_crossing_force_step(detector: *mut narx_zero_crossing_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(detector) }.map(ZeroCrossing::force_step))
}

/// Runs one tick with the samples (phase and bus voltages with their mode, edges of comparators) and the
/// pattern that was applied in the period that has ended, with torque in direction `towards` (0 forward, 1
/// reverse).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_zero_crossing_step(
    detector: *mut narx_zero_crossing_t,
    samples: *const narx_samples_t,
    applied: *const narx_applied_t,
    towards: u8,
    reading: *mut narx_zero_crossing_reading_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(reading)?;
        let detector = handle::object(detector)?;
        let mut converted = Samples::default();
        pointer::read(samples)?.convert(&mut converted)?;
        let applied = PwmCommand::try_from(pointer::read(applied)?)?;
        pointer::write(reading, detector.step(&converted, &applied, direction(towards)?).into())
    };
    pointer::status(run())
}

impl TryFrom<&narx_applied_t> for PwmCommand {
    type Error = narx_status_t;

    fn try_from(applied: &narx_applied_t) -> Result<Self, narx_status_t> {
        let &narx_applied_t { sample_at, step, commutation_count, instants, steps } = applied;
        let known = |step| Step::from_number(step).ok_or(NARX_ERROR_ARGUMENT);
        let mut command = Self { sample_at, step: known(step)?, ..Self::default() };
        if usize::from(commutation_count) > NARX_COMMUTATIONS_MAX {
            return Err(NARX_ERROR_ARGUMENT);
        }
        for (instant, step) in instants.into_iter().zip(steps).take(commutation_count.into()) {
            command.commutations.push(Commutation { instant, step: known(step)? });
        }
        Ok(command)
    }
}

impl From<ZeroCrossingReading> for narx_zero_crossing_reading_t {
    fn from(reading: ZeroCrossingReading) -> Self {
        let ZeroCrossingReading {
            crossing,
            why,
            margin,
            accepted,
            position,
            speed,
            commutation,
            running,
            lost,
        } = reading;
        Self {
            crossing: crossing.unwrap_or(i32::MIN),
            commutation: commutation.unwrap_or(u32::MAX),
            angle: position.angle,
            turn_speed: position.speed,
            speed: speed.to_bits(),
            accepted,
            margin,
            why: why as u8,
            running: running.into(),
            lost: lost as u8,
        }
    }
}
