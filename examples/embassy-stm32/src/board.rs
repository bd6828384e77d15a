//! The board in figures: counts of the timers, codes of the converters, and its description for the core.
//!
//! | quantity | network | figure |
//! |---|---|---|
//! | bus voltage | 169 kohm, 9.31 kohm | 15.43 mV a code |
//! | terminals | 10 kohm, 2.2 kohm, connected by PC9 | 4.468 mV a code, up to 18.3 V |
//! | phase currents | 10 milliohm, amplifier of 5.18 | 15.55 mA a code about 1.71 V |
//! | temperature | thermistor | 1.055 V at 25 degrees Celsius, 22.7 mV a degree |
//!
//! The terminals' network is an assumption: the power board's schematic decides. The program `check`
//! compares.

use narx_board::stm32::{self, Gates};
use narx_core::motor::{Board, Channel, Equipment, FrontEnd, SampleMode};
use narx_core::units::{Celsius, Duty};

/// Clock of processor and timers, Hz.
pub const CLOCK_HZ: u32 = 150_000_000;
/// PWM periods a second.
pub const TICK_RATE: u32 = 20_000;
/// Counts of a period, up and down.
pub const PERIOD: u16 = (CLOCK_HZ / TICK_RATE) as u16;
/// Count at which TIM1 turns round.
pub const TOP: u16 = PERIOD / 2;
/// Both switches of a leg stay off this long, ns. The L6398 keeps 320 ns by itself.
pub const DEAD_TIME_NS: u16 = 800;
/// [`DEAD_TIME_NS`] in counts.
pub const DEAD_TIME: u16 = counts(DEAD_TIME_NS as u32);
/// Its share of the period, raw U1F15.
const DEAD_SHARE: u16 = ((DEAD_TIME as u32) << 15).div_ceil(PERIOD as u32) as u16;
/// Shortest time that a switched leg's low side is on in a period, ns: it charges the bootstrap capacitor.
const BOOTSTRAP_NS: u32 = 2_000;
/// Largest compare value.
pub const COMPARE_MAX: u16 = TOP - (counts(BOOTSTRAP_NS) + 2 * DEAD_TIME) / 2;

/// The board's description for the core.
pub const BOARD: Board = Board {
    tick_rate: TICK_RATE,
    // 25 us: conversions of 2.9 us and the longest control tick.
    earliest: 32_768,
    dead_time_ns: DEAD_TIME_NS,
    bridge_milliohm: 4,
    hall_capture: false,
    comparator_capture: false,
    equipment: Equipment::empty(),
    front_end: FrontEnd {
        bus_voltage: Channel { zero: 0, micro_per_code: 15_430 },
        phase_voltage: Channel { zero: 0, micro_per_code: 15_430 },
        bus_current: Channel { zero: CURRENT_ZERO, micro_per_code: 8_000 },
    },
};
/// From the bus voltage's conversion to phase C's, 1/65 536 of a period: three conversions of 25 clocks of
/// 37.5 MHz.
pub const SKEW: u16 = 2_621;

/// Code of no bus current in the samples.
pub const CURRENT_ZERO: u16 = 2_048;
/// Nominal code of no phase current: 1.71 V.
pub const SHUNT_ZERO: u16 = 2_122;
/// Largest deviation of the measured zero from it, codes: 0.2 V. Beyond, shunt or amplifier is broken.
pub const SHUNT_ZERO_TOLERANCE: u16 = 248;
/// A terminal's code in codes of the bus voltage, 1/65 536.
const TERMINAL_TO_BUS: u32 = 18_977;
/// From here on a terminal's divider is taken as beyond its end.
const SATURATED: u16 = 4_090;
/// A shunt's code in codes of the bus current, 1/65 536.
const SHUNT_TO_BUS: i64 = 127_414;

const fn counts(ns: u32) -> u16 {
    (ns as u64 * CLOCK_HZ as u64).div_ceil(1_000_000_000) as u16
}

/// Returns the compare value of a leg that is switched with `duty`.
pub fn compare(duty: Duty) -> u16 {
    let compare = (u32::from(duty.to_bits()) * u32::from(TOP)) >> 15;
    (compare as u16).min(COMPARE_MAX)
}

/// Returns the counts from the period's boundary to `instant`, 1/65 536 of a period.
pub const fn part(instant: u16) -> u16 {
    ((instant as u32 * PERIOD as u32) >> 16) as u16
}

/// Returns the compare value that triggers the converters at `sample_at`, 1/65 536 of a period: in its first
/// half, while the count rises.
pub fn sample_compare(sample_at: u16) -> u16 {
    part(sample_at).clamp(1, TOP - 1)
}

/// Returns whether the instant `at`, a count of TIM2, has come.
pub const fn has_come(at: u32, now: u32) -> bool {
    now.wrapping_sub(at) < 1 << 31
}

/// Returns a terminal's code in the scale of the bus voltage. A switched leg in the middle of its on-time is
/// at the bus, which the divider cannot show above 18.3 V.
pub const fn terminal(code: u16, gates: Gates, mode: SampleMode, bus: u16) -> u16 {
    let switched = matches!(gates, Gates::Complementary | Gates::HighOnly);
    if code >= SATURATED && switched && matches!(mode, SampleMode::OnTime) {
        return bus;
    }
    ((code as u32 * TERMINAL_TO_BUS) >> 16) as u16
}

/// Returns the mean bus current as a code about [`CURRENT_ZERO`], of shunt codes above their zeros that were
/// sampled in the middle of `sampled`.
pub fn bus_current(shunts: [i32; 3], gates: [Gates; 3], duty: Duty, sampled: SampleMode) -> u16 {
    let codes = (stm32::bus_current(shunts, gates, duty, DEAD_SHARE, sampled) * SHUNT_TO_BUS) >> 31;
    (i64::from(CURRENT_ZERO) + codes).clamp(0, i64::from(FrontEnd::CODE_MAX)) as u16
}

/// Returns the power board's temperature of the thermistor's code.
pub fn temperature(code: u16) -> Celsius {
    let millivolts = i32::from(code) * 3_300 / 4_096;
    Celsius::from_milli(25_000 + (millivolts - 1_055) * 10_000 / 227)
}
