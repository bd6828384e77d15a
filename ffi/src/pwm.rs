//! Command of the control tick.

use narx_core::motor::{Commutation, PwmCommand, Rectification, SampleMode, Step};

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
    /// The pattern to apply at once, when narx_drive_step returns. Coast turns all six switches off.
    pub step: Step,
    /// Number of valid entries of `commutations`.
    pub commutation_count: u8,
    /// Pattern changes later in period k, in order of time, none before the board's `earliest`.
    pub commutations: [narx_commutation_t; NARX_COMMUTATIONS_MAX],
}

impl From<PwmCommand> for narx_pwm_command_t {
    fn from(command: PwmCommand) -> Self {
        let PwmCommand { duty, rectification, sample_at, sample_mode, step, commutations } = command;
        let mut converted = Self {
            duty: duty.to_bits(),
            sample_at,
            sample_mode,
            rectification,
            step,
            commutation_count: 0,
            commutations: [narx_commutation_t { instant: 0, step: Step::Coast }; NARX_COMMUTATIONS_MAX],
        };
        for (place, Commutation { instant, step }) in
            converted.commutations.iter_mut().zip(commutations.iter())
        {
            *place = narx_commutation_t { instant, step };
            converted.commutation_count += 1;
        }
        converted
    }
}
