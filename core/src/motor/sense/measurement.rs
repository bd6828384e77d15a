//! Converter codes to volts and amperes, with calibration, and volts to duty.

use super::front_end::Channel;
use super::samples::Samples;
use crate::units::{Amps, Duty, Volts, quotient};
use serde::{Deserialize, Serialize};

/// One converter channel: `value = (code - zero) x gain + offset`, as one multiplication and one sum.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct ChannelScale {
    /// Raw I16F16 per code, with 16 extra bits.
    gain: u32,
    /// Offset that is added to every value, raw I16F16; `bias` contains it.
    offset: i32,
    /// Value of code 0, raw I16F16 with 32 extra bits.
    bias: i64,
}

/// No credible calibration offset is larger: 256 V or A, raw I16F16.
const OFFSET_MAX: i32 = 1 << 24;

impl ChannelScale {
    /// For a channel of at most [`Channel::MICRO_PER_CODE_MAX`]; `offset` (raw I16F16) is added.
    pub const fn new(channel: Channel, offset: i32) -> Self {
        let micro = if channel.micro_per_code > Channel::MICRO_PER_CODE_MAX {
            Channel::MICRO_PER_CODE_MAX
        } else {
            channel.micro_per_code
        };
        let micro = if micro > 0 { micro as i64 } else { 0 };
        let gain = quotient(micro << 32, 1_000_000);
        let offset = if offset > OFFSET_MAX {
            OFFSET_MAX
        } else if offset < -OFFSET_MAX {
            -OFFSET_MAX
        } else {
            offset
        };
        Self {
            gain: gain as u32,
            offset,
            bias: ((offset as i64) << 32) - ((gain * channel.zero as i64) << 16),
        }
    }

    /// Raw I16F16 of `code`: the upper word of one product and one sum.
    #[inline]
    pub const fn convert(&self, code: u16) -> i32 {
        let product = ((code as u32) << 16) as u64 * self.gain as u64;
        ((product as i64 + self.bias) >> 32) as i32
    }

    /// The least code that converts to `value` (raw I16F16) or more; 0 or the largest where there is none.
    pub const fn code_of(&self, value: i32) -> u16 {
        let (gain, least) = ((self.gain as i64) << 16, ((value as i64) << 32) - self.bias);
        let code = quotient(least + gain - 1, gain);
        if code < 0 {
            0
        } else if code > u16::MAX as i64 {
            u16::MAX
        } else {
            code as u16
        }
    }

    /// Voltages of the three terminals. Only listening and reports ask for them.
    pub fn convert_all(&self, codes: &[u16; 3]) -> [Volts; 3] {
        codes.map(|code| Volts::from_bits(self.convert(code)))
    }

    /// Codes of a difference (raw I16F16), rounded down: by a 32-bit division, whose divisor keeps the 7 and
    /// more bits of a channel's gain.
    pub const fn codes_of_difference(&self, difference: i32) -> i32 {
        let gain = (self.gain >> 16) as i32;
        difference / if gain > 0 { gain } else { 1 }
    }

    /// Raw I16F16 of a difference of `codes`, within 2^18: zero and offset cancel.
    #[inline]
    pub const fn convert_difference(&self, codes: i32) -> i32 {
        ((codes as i64 * self.gain as i32 as i64) >> 16) as i32
    }
}

/// Scales of the fast channels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct MeasurementScales {
    /// Bus voltage (parameter 14 is its offset).
    pub bus_voltage: ChannelScale,
    /// DC-link current (parameter 13 is its offset).
    pub bus_current: ChannelScale,
    /// Phase terminal voltages.
    pub phase_voltage: ChannelScale,
    /// Periods of 100 us in a tick, 1/65 536: the filter of the bus current takes 1/64 of a difference in
    /// each.
    pub filter: u32,
}

/// Measurements of this tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Measured {
    /// Bus voltage.
    pub bus_voltage: Volts,
    /// Mean DC-link current.
    pub bus_current: Amps,
    /// Bus current after a first-order filter of 6.4 ms, longer than a commutation returns current to the
    /// bus.
    pub bus_current_filtered: Amps,
}

/// State of the measurement station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Measurement {
    /// Mean bus current, raw I16F16 with 6 extra bits.
    filtered: i32,
    zero: ZeroCurrent,
    /// Bus voltage, raw I16F16.
    bus_voltage: i32,
}

/// The bus current's zero, found while the bridge is off: what the channel reads then, without parameter 13,
/// is its own offset. It is looked for as long as nothing is driven and not at power-up alone, because what
/// is wrong then may be mended, and a shunt's amplifier drifts as it warms.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct ZeroCurrent {
    /// A first-order mean of 64 ms, raw I16F16 with 6 extra bits.
    mean: i64,
    /// The mean, limited to the largest credible offset.
    zero: i32,
}

impl ZeroCurrent {
    /// No credible offset is larger: 0.25 A.
    const MAX: i32 = 1 << 14;
    /// More is no offset but a current, of windings that are just let go or of a rotor that is turned faster
    /// than the bus allows: 0.5 A.
    const FLOWS: i32 = 2 * Self::MAX;

    fn find(&mut self, current: i32) {
        if current.saturating_abs() > Self::FLOWS {
            return;
        }
        self.mean += i64::from(current) - (self.mean >> 6);
        self.zero = ((self.mean >> 6) as i32).clamp(-Self::MAX, Self::MAX);
    }
}

/// The filter's room: 256 A, raw I16F16.
const FILTER_MAX: i32 = 1 << 24;

impl Measurement {
    /// Converts one tick's codes; the answer is the mean bus current.
    #[inline]
    pub fn step(&mut self, scales: &MeasurementScales, samples: &Samples) -> Amps {
        self.bus_voltage = scales.bus_voltage.convert(samples.bus_voltage);
        let bus_current = scales.bus_current.convert(samples.bus_current) - self.zero.zero;
        let more = bus_current.clamp(-FILTER_MAX, FILTER_MAX - 1) - (self.filtered >> 6);
        self.filtered += ((i64::from(more) * i64::from(scales.filter)) >> 16) as i32;
        Amps::from_bits(bus_current)
    }

    /// Once a millisecond with the bridge off, in a step that answered `bus_current`: what the current's
    /// channel reads is its zero.
    pub fn find_zero(&mut self, scales: &MeasurementScales, bus_current: Amps) {
        self.zero.find(bus_current.to_bits() + self.zero.zero - scales.bus_current.offset);
    }

    /// All of the last step, which answered `bus_current`.
    pub const fn measured(&self, bus_current: Amps) -> Measured {
        Measured {
            bus_voltage: Volts::from_bits(self.bus_voltage),
            bus_current,
            bus_current_filtered: Amps::from_bits(self.filtered >> 6),
        }
    }

    /// Bus voltage as of the last step, raw I16F16.
    #[inline]
    pub const fn bus_voltage(&self) -> i32 {
        self.bus_voltage
    }

    /// Bus current of one period as [`step`](Self::step) saw it, raw I16F16.
    pub const fn bus_current_of(&self, scales: &MeasurementScales, samples: &Samples) -> i32 {
        scales.bus_current.convert(samples.bus_current).wrapping_sub(self.zero.zero)
    }

    /// Filtered bus current as of the last step, raw I16F16.
    #[inline]
    pub const fn bus_current(&self) -> i32 {
        self.filtered >> 6
    }

    /// The duty that gives `voltage` (raw I16F16) on the present bus, 0..=1, rounded down; the bus counts as
    /// at least 4 V.
    ///
    /// One 32-bit division, which the processor has: both are scaled until the divisor keeps 16 bits.
    #[inline]
    pub const fn duty(&self, voltage: i32) -> Duty {
        let bus = if self.bus_voltage > BUS_MIN { self.bus_voltage as u32 } else { BUS_MIN as u32 };
        let voltage = if voltage > 0 { voltage as u32 } else { 0 };
        if voltage >= bus {
            return Duty::ONE;
        }
        Duty::from_bits(ratio(voltage, bus) as u16)
    }

    /// Returns the [`duty`](Self::duty) in 1/32 768, on a bus above `BUS_MIN`, of a positive voltage below
    /// the bus.
    #[inline]
    pub const fn duty_within(&self, voltage: i32) -> u32 {
        ratio(voltage as u32, self.bus_voltage as u32)
    }
}

/// `part / whole` in 1/32 768, for a part below the whole: both are shifted until the whole has 32 bits.
#[inline]
pub(in crate::motor) const fn ratio(part: u32, whole: u32) -> u32 {
    let shift = (whole | 1).leading_zeros();
    // Of the divisor's 16 bits the highest is set, and it is not 0.
    ((part << shift) >> 1) / (((whole << shift) >> 16) | (1 << 15))
}

/// Below 4 V nothing runs; from there on the bus voltage has more than 16 bits.
pub(in crate::motor) const BUS_MIN: i32 = 4 << 16;
