//! Counts of the timers' clock: the period, instants in it, the dead time.
//!
//! TIM1 makes the PWM. It counts up and down, so that every on-time is centred on the count 0, which is the
//! boundary of the period:
//!
//! ```text
//!  count of TIM1   0 ── up ──> 8500 ── down ──> 0        on while the count is below the compare value
//!                  |on|        off         |on |
//!  period          0                        1
//!  count of TIM4   free running, 65 536 counts = 3.86 periods: captures of the hall lines, instants of commutations
//! ```
//!
//! Both run from the same clock, so a boundary is known in counts of TIM4 whenever TIM1 is read beside it.

use narx_core::units::Duty;

/// Clock of processor and timers, Hz.
pub const CLOCK_HZ: u32 = 170_000_000;
/// Periods a second.
pub const TICK_RATE: u32 = if cfg!(feature = "pwm-20-khz") { 20_000 } else { 10_000 };
/// Counts of a period.
pub const PERIOD: u16 = (CLOCK_HZ / TICK_RATE) as u16;
/// Count at which TIM1 turns round.
pub const TOP: u16 = PERIOD / 2;
/// Both switches of a leg stay off this long, ns: what ST drives this board with (Motor Control Workbench).
pub const DEAD_TIME_NS: u16 = 800;
/// [`DEAD_TIME_NS`] in counts.
pub const DEAD_TIME: u16 = counts(DEAD_TIME_NS as u32);
/// A switched leg's low side is on at least this long in every period, ns: what charges the gate driver's
/// bootstrap capacitor.
pub const BOOTSTRAP_NS: u16 = 2_000;
/// Largest compare value: that low-side time and two dead times are left.
pub const COMPARE_MAX: u16 = TOP - (counts(BOOTSTRAP_NS as u32) + 2 * DEAD_TIME) / 2;

/// A time in counts, rounded up.
pub const fn counts(ns: u32) -> u16 {
    (ns as u64 * CLOCK_HZ as u64).div_ceil(1_000_000_000) as u16
}

/// The compare value of a leg that is switched with `duty`.
pub fn compare(duty: Duty) -> u16 {
    let compare = (u32::from(duty.to_bits()) * u32::from(TOP)) >> 15;
    (compare as u16).min(COMPARE_MAX)
}

/// The compare value that triggers the converter at `sample_at`, 1/65 536 of a period: while the count rises,
/// so in its first half.
pub fn sample_compare(sample_at: u16) -> u16 {
    part(sample_at).clamp(1, TOP - 1)
}

/// Counts from the boundary to `instant`, 1/65 536 of a period.
pub const fn part(instant: u16) -> u16 {
    ((instant as u32 * PERIOD as u32) >> 16) as u16
}

/// The instant, 1/65 536 of a period, that is `counts` after its boundary; the last one for a whole period or
/// more.
pub const fn instant(counts: u16) -> u16 {
    if counts >= PERIOD {
        return u16::MAX;
    }
    // Rounded, which ends below 65 536 for all but the last counts.
    let instant = (((counts as u32) << 16) + PERIOD as u32 / 2) / PERIOD as u32;
    if instant > u16::MAX as u32 { u16::MAX } else { instant as u16 }
}

/// Counts since the boundary at a count of TIM1 and its direction.
pub const fn position(count: u16, down: bool) -> u16 {
    if down { PERIOD.wrapping_sub(count) } else { count }
}

/// Returns whether the instant `at` (count of TIM4) has come: less than half of the counter's range ago.
pub const fn has_come(at: u16, now: u16) -> bool {
    now.wrapping_sub(at) < 1 << 15
}
