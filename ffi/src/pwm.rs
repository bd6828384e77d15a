//! Command of the control tick.

use crate::pointer;
use crate::samples::narx_samples_t;
use crate::status::narx_status_t::{self, *};
use narx_core::motor::{Commutation, Commutations, PwmCommand, Rectification, SampleMode, Samples, Step};

/// Largest number of pattern changes in one period.
pub const NARX_COMMUTATIONS_MAX: usize = 2;

/// One pattern change.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_commutation_t {
    /// Instant of the change, in 1/65 536 of the period.
    pub instant: u16,
    /// Pattern from then on.
    pub step: Step,
}

/// The answer to the samples of period k. `step` and `commutations` act in period k, the rest from period k +
/// 1.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_pwm_command_t {
    /// Duty of the switched legs in period k + 1: U1F15, at most 32 768 = 1. The on-time is centred on the
    /// period's boundary.
    pub duty: u16,
    /// Sampling instant in period k + 1, in 1/65 536 of it.
    pub sample_at: u16,
    /// Part of the period in which that sample is taken.
    pub sample_mode: SampleMode,
    /// Freewheeling in period k + 1.
    pub rectification: Rectification,
    /// The pattern to apply at once, when the call that writes it returns. Coast turns all six switches off.
    pub step: Step,
    /// Number of valid entries of `commutations`.
    pub commutation_count: u8,
    /// Pattern changes later in period k, in order of time, none before the board's `earliest`.
    pub commutations: [narx_commutation_t; NARX_COMMUTATIONS_MAX],
}

impl From<PwmCommand> for narx_pwm_command_t {
    fn from(command: PwmCommand) -> Self {
        let PwmCommand { duty, rectification, sample_at, sample_mode, step, commutations } = command;
        let (commutation_count, commutations) = told(commutations);
        Self {
            duty: duty.to_bits(),
            sample_at,
            sample_mode,
            rectification,
            step,
            commutation_count,
            commutations,
        }
    }
}

/// Returns the number of changes, and the changes; those that do not come are coast at 0.
pub(crate) fn told(commutations: Commutations) -> (u8, [narx_commutation_t; NARX_COMMUTATIONS_MAX]) {
    let changes = commutations.both();
    let none = narx_commutation_t { instant: 0, step: Step::Coast };
    (
        changes.map(|change| u8::from(change.is_some())).iter().sum(),
        changes.map(|change| {
            change.map_or(none, |Commutation { instant, step }| narx_commutation_t { instant, step })
        }),
    )
}

/// Runs a control tick of `object`. On an error the command is coast at duty 0.
///
/// # Safety
/// The pointers are as [`pointer::read`] and [`pointer::write`] ask, and `object` may be called.
pub(crate) unsafe fn step<'a, T: 'a>(
    samples: *const narx_samples_t,
    command: *mut narx_pwm_command_t,
    object: impl FnOnce() -> Result<&'a mut T, narx_status_t>,
    step: impl FnOnce(&mut T, &Samples) -> PwmCommand,
) -> narx_status_t {
    // SAFETY: the caller's promise.
    let run = || unsafe {
        pointer::check(command)?;
        let mut converted = Samples::default();
        pointer::read(samples)?.convert(&mut converted)?;
        Ok(step(object()?, &converted))
    };
    let (answer, status) = match run() {
        Ok(answer) => (answer, NARX_OK),
        Err(error) => (PwmCommand::default(), error),
    };
    // SAFETY: the caller's promise.
    match unsafe { pointer::write(command, answer.into()) } {
        Ok(()) => status,
        Err(error) => error,
    }
}
