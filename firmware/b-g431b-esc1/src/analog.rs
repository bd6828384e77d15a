//! Converter codes to what the drive reads.
//!
//! | channel | network | a 12-bit code of 3.3 V |
//! |---|---|---|
//! | bus voltage | 169 kohm, 18 kohm | 8.370 mV |
//! | phase voltage | 10 kohm, 2.2 kohm, switched on by PB5 | 4.468 mV, up to 18.3 V |
//! | phase current | 3 milliohm, network of 0.571, amplifier of 16 | 29.40 mA about 2.057 V |
//!
//! The drive wants one scale for all voltages and the mean current of the bus. Phase codes are brought to the
//! bus voltage's scale. The bus current is made of what the legs carry to ground
//! ([`stm32::bus_current`]).

use crate::timing::{DEAD_TIME, PERIOD};
use narx_board::stm32::{self, Gates};
use narx_core::motor::{Channel, FrontEnd, SampleMode};
use narx_core::units::{Celsius, Duty, Volts};

/// Codes of the converter.
const CODES: i32 = 4096;
/// Nominal supply of the analogue part, and full scale, mV.
const SUPPLY_MV: i32 = 3300;

/// Scales of `Samples`.
pub const FRONT_END: FrontEnd = FrontEnd {
    bus_voltage: Channel { zero: 0, micro_per_code: 8_370 },
    phase_voltage: Channel { zero: 0, micro_per_code: 8_370 },
    bus_current: Channel { zero: CURRENT_ZERO, micro_per_code: 8_000 },
};

/// Code of no bus current in `Samples`.
pub const CURRENT_ZERO: u16 = 2048;
/// Nominal code of a phase current of 0: 2.057 V.
pub const SHUNT_ZERO: u16 = 2553;
/// Largest deviation of the measured zero from [`SHUNT_ZERO`], codes: 0.2 V. Beyond, shunt or amplifier is
/// broken.
pub const SHUNT_ZERO_TOLERANCE: u16 = 248;

/// A phase code to the bus voltage's scale: (169 + 18) / 18 of it against (10 + 2.2) / 2.2, in 1/65 536.
const PHASE_TO_BUS: u32 = 34_982;
/// From here on a divider is taken as beyond its end.
const SATURATED: u16 = 4090;
/// 29.395 mA a code of a shunt in codes of 8 mA, in 1/65 536.
const SHUNT_TO_BUS: i64 = 240_817;

/// Share of the dead time in a period, raw U1F15.
const DEAD_SHARE: u16 = ((DEAD_TIME as u32) << 15).div_ceil(PERIOD as u32) as u16;

/// A terminal's code in the scale of the bus voltage. In the middle of the on-time a switched leg is at the
/// bus, which the divider cannot show above 18.3 V; a floating one beyond that is left at the divider's end,
/// far from the half of the bus at which anything depends on it.
pub const fn terminal(code: u16, gates: Gates, mode: SampleMode, bus: u16) -> u16 {
    let switched = matches!(gates, Gates::Complementary | Gates::HighOnly);
    if code >= SATURATED && switched && matches!(mode, SampleMode::OnTime) {
        return bus;
    }
    ((code as u32 * PHASE_TO_BUS) >> 16) as u16
}

/// Mean bus current as a code about [`CURRENT_ZERO`], of shunt codes above their zeros, positive from the
/// phase to ground, which were sampled in the middle of `sampled`.
pub fn bus_current(shunts: [i32; 3], gates: [Gates; 3], duty: Duty, sampled: SampleMode) -> u16 {
    let codes = (stm32::bus_current(shunts, gates, duty, DEAD_SHARE, sampled) * SHUNT_TO_BUS) >> 31;
    (i64::from(CURRENT_ZERO) + codes).clamp(0, i64::from(FrontEnd::CODE_MAX)) as u16
}

/// The code of the converter from digital to analogue that a comparator on a shunt's network compares with,
/// to trip at so many amperes: 0.1286 V of bias and 1.713 mV an ampere.
pub const fn trip_code(amperes: u16) -> u16 {
    let microvolts = 128_563 + 1_713 * amperes as i32;
    (microvolts * CODES / (SUPPLY_MV * 1000)) as u16
}

/// Volts at a pin.
pub fn pin(code: u16) -> Volts {
    Volts::from_milli(i32::from(code) * SUPPLY_MV / CODES)
}

/// 0.383 of the analogue part's supply, by the code of the internal reference and the code that its maker
/// read at 3.0 V (DS12589, section 3.18.2). A code of 0 counts as 1.
pub fn reference_tap(reference: u16, at_3v: u16) -> Volts {
    Volts::from_milli(3 * 383 * i32::from(at_3v) / i32::from(reference.max(1)))
}

/// Codes of the thermistor from -20 degrees C on in steps of 10: 10 kohm at 25 degrees to the supply, 4.7
/// kohm to ground. 1.055 V at 25 degrees is ST's figure; the B of 3435 K is an estimate.
const THERMISTOR: [u16; 16] =
    [234, 378, 576, 833, 1141, 1484, 1841, 2187, 2506, 2787, 3026, 3224, 3385, 3515, 3620, 3704];
const THERMISTOR_FROM: i32 = -20;
const THERMISTOR_STEP: i32 = 10;

/// Temperature of the board by the thermistor's code, between two of the table; beyond its ends theirs.
pub fn temperature(code: u16) -> Celsius {
    let mut degrees = THERMISTOR_FROM;
    for pair in THERMISTOR.windows(2) {
        if let [before, next] = *pair
            && code < next
        {
            let beyond = i32::from(code.saturating_sub(before)) * THERMISTOR_STEP * 1000;
            return Celsius::from_milli(1000 * degrees + beyond / i32::from(next - before));
        }
        degrees += THERMISTOR_STEP;
    }
    Celsius::from_milli(1000 * degrees)
}
