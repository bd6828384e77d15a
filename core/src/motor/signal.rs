//! The signals of the scope: quantities of a drive, tick by tick.

use crate::dictionary::Decimal;
use serde::{Deserialize, Serialize};

/// A signal of the drive. Its number is its bit in parameter 22.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Signal {
    /// Speed set-point after saturation and ramp.
    SetPoint = 0,
    /// Speed by back-EMF.
    SpeedSensorless = 1,
    /// Speed by the hall sensors.
    SpeedHall = 2,
    /// Bus voltage.
    BusVoltage = 3,
    /// Bus current, mean of 64 ticks.
    BusCurrent = 4,
    /// Bus voltage times that.
    Power = 5,
    /// Voltage at terminal A.
    TerminalA = 6,
    /// Voltage at terminal B.
    TerminalB = 7,
    /// Voltage at terminal C.
    TerminalC = 8,
    /// Duty of the next period.
    Duty = 9,
    /// Electrical angle that the commutation uses.
    Angle = 10,
    /// Exact state (section 7).
    State = 11,
    /// The limit that bounds the duty (parameter 280).
    Limiter = 12,
    /// Step that is applied: 0 coast, 1 AB, 2 AC, 3 BC, 4 BA, 5 CA, 6 CB, more: rotor lock.
    Step = 13,
    /// Hall lines as read.
    Hall = 14,
    /// Outcome of the last zero crossing (parameter 287).
    Crossing = 15,
    /// Distance of the last accepted one behind its prediction (parameter 288).
    CrossingMargin = 16,
    /// Voltage that the speed loop wants.
    LoopVoltage = 17,
    /// Estimated phase current.
    PhaseCurrent = 18,
    /// Bus current, mean of one period.
    PeriodCurrent = 19,
    /// Lowest bit of FAULT_WORD that is set; -1 without one.
    Fault = 20,
    /// Digital inputs: 1 driver fault, 2 emergency, 4 DSI1, 8 DSI2.
    Inputs = 21,
    /// Mechanical angle since power-up within a revolution, to one sector.
    Position = 22,
}

/// A signal as it is published.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignalRow {
    /// Which one.
    pub signal: Signal,
    /// Its name; one that is broadcast, too, has the name of Figure 14.
    pub name: &'static str,
    /// Unit of the value; "-" without one.
    pub unit: &'static str,
    /// Value of 1 per unit: value = sample * base / 4096, from -8 to almost 8 bases (Q3.12).
    pub base: Decimal,
}

/// Every signal in the order of its bit. Speeds are mechanical, and negative in reverse.
pub const DRIVE_SIGNALS: [SignalRow; 23] = [
    row(Signal::SetPoint, "Speed set-point", "rpm", SPEED_BASE),
    row(Signal::SpeedSensorless, "Mechanical estimated speed SL", "rpm", SPEED_BASE),
    row(Signal::SpeedHall, "Mechanical estimated speed HES", "rpm", SPEED_BASE),
    row(Signal::BusVoltage, "HV Voltage", "V", 16),
    row(Signal::BusCurrent, "HV Current", "A", 2),
    row(Signal::Power, "Electrical input Power", "W", 64),
    row(Signal::TerminalA, "VoltagePhaseA", "V", 16),
    row(Signal::TerminalB, "VoltagePhaseB", "V", 16),
    row(Signal::TerminalC, "VoltagePhaseC", "V", 16),
    row(Signal::Duty, "Duty", "%", 100),
    row(Signal::Angle, "Electrical angle", "deg", 360),
    row(Signal::State, "Drive state", "-", 1),
    row(Signal::Limiter, "Active limiter", "-", 2),
    row(Signal::Step, "Step", "-", 2),
    row(Signal::Hall, "Hall code", "-", 1),
    row(Signal::Crossing, "Last zero crossing", "-", 1),
    row(Signal::CrossingMargin, "Zero crossing margin", "deg", 45),
    row(Signal::LoopVoltage, "Speed loop voltage", "V", 16),
    row(Signal::PhaseCurrent, "Phase current", "A", 2),
    row(Signal::PeriodCurrent, "HV Current of one period", "A", 2),
    row(Signal::Fault, "Fault bit", "-", 4),
    row(Signal::Inputs, "Digital inputs", "-", 2),
    row(Signal::Position, "Mechanical position", "deg", 360),
];

/// Speeds, rpm.
const SPEED_BASE: i64 = 5000;

const fn row(signal: Signal, name: &'static str, unit: &'static str, base: i64) -> SignalRow {
    SignalRow { signal, name, unit, base: Decimal { digits: base, exponent: 0 } }
}

const fn signals() -> [Signal; DRIVE_SIGNALS.len()] {
    let mut signals = [Signal::SetPoint; DRIVE_SIGNALS.len()];
    let mut bit = 0;
    while bit < signals.len() {
        signals[bit] = DRIVE_SIGNALS[bit].signal;
        bit += 1;
    }
    signals
}

impl Signal {
    /// The signal of a bit of parameter 22.
    pub fn of_bit(bit: u8) -> Option<Self> {
        // Not from the rows: who only records needs no names.
        const ALL: [Signal; DRIVE_SIGNALS.len()] = signals();
        ALL.get(usize::from(bit)).copied()
    }
}

/// Electrical quantities of the shaft to samples of mechanical ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShaftScale {
    /// Samples a raw rev/s, 32 fraction bits.
    speed: i32,
    /// Sectors a mechanical revolution.
    sectors: u16,
}

impl Default for ShaftScale {
    /// One pole pair.
    fn default() -> Self {
        Self::new(1)
    }
}

impl ShaftScale {
    /// For so many pole pairs; 0 counts as 1.
    pub const fn new(pole_pairs: u16) -> Self {
        let pole_pairs = if pole_pairs == 0 { 1 } else { pole_pairs as i64 };
        // Samples of 1 rpm, times 60 rpm of 1 rev/s, with 32 fraction bits less the raw value's 16.
        let speed = (((60 * 4096) << 16) / (SPEED_BASE * pole_pairs)) as i32;
        Self { speed, sectors: (6 * pole_pairs) as u16 }
    }

    /// The sample of an electrical `speed` (raw I16F16 rev/s), not yet saturated.
    #[inline]
    pub const fn speed(self, speed: i32) -> i32 {
        ((speed as i64 * self.speed as i64) >> 32) as i32
    }

    /// The sample of so many `sectors` since power-up: the place within a mechanical revolution, 0 to 4095.
    #[inline]
    pub const fn position(self, sectors: i32) -> i32 {
        let revolution = if self.sectors == 0 { 6 } else { self.sectors as i32 };
        // Not `rem_euclid`, which can panic.
        let place = sectors % revolution;
        let place = if place < 0 { place + revolution } else { place };
        (place << 12) / revolution
    }
}
