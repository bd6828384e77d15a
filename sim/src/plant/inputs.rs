//! Inputs that the board reads besides the tick's samples: the values on its wires, and the codes that its
//! converter makes of them.

use super::Plant;
use core::fmt;
use narx_core::bus::narmotion::DigitalOutputs;
use narx_core::dictionary::Decimal;
use narx_core::motor::Lines;
use narx_core::node::{Outputs, SlowInputs};
use narx_core::units::{Celsius, Volts};

/// A slow input, in units of what it measures. Ranges are those of Table 2 where it has them, and of the
/// simulated board elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Open-circuit voltage of the source at the analog signal input, 0..=3.3 V.
    Asi,
    /// Resistance of that source, 0..=1 000 000 ohm: the input's 20 kohm load it.
    AsiSource,
    /// Acceleration along X, -2..=2 g.
    AccelX,
    /// Acceleration along Y, -2..=2 g.
    AccelY,
    /// Acceleration along Z, -2..=2 g.
    AccelZ,
    /// Differential output of the pressure bridge, 0..=55 mV.
    Pressure,
    /// Common mode of the pressure bridge, 0..=5 V; 2.5 V is a balanced one.
    PressureCommonMode,
    /// 6 V rail, 0..=8 V.
    Rail6V,
    /// 14 V rail of the gate drivers, 0..=20 V.
    Rail14V,
    /// 1.8 V reference of the accelerometer, whose outputs follow it, 0..=3.3 V.
    AccelReference,
    /// 0.383 VREF, 0..=3.3 V.
    Reference,
    /// Sensor on the power board, -55..=250 degrees Celsius: the ambient temperature.
    InternalTemperature,
    /// External sensor, -55..=250 degrees Celsius.
    ExternalTemperature,
    /// Voltage that drives DSIO1 from outside, 0..=3.3 V.
    Dsio1,
    /// Voltage that drives DSIO2 from outside, 0..=3.3 V.
    Dsio2,
    /// Supply of the hall sensors while the drive has it on, 0..=5.5 V.
    HallSupply,
}

/// A value that no wire can carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InputError {
    /// Input that the value was meant for.
    pub input: Input,
    /// The value that was refused.
    pub value: f64,
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Row { min, max, unit, .. } = self.input.row();
        // The value may be anything, and its text would bring all of float formatting with it.
        let [min, max] = [min, max].map(|milli| Decimal { digits: *milli as i64, exponent: -3 });
        write!(f, "{:?} takes {min} to {max} {unit}", self.input)
    }
}

impl core::error::Error for InputError {}

/// Name, range in thousandths of the unit, and the value at the start.
struct Row {
    name: &'static str,
    min: f64,
    max: f64,
    unit: &'static str,
    start: f64,
}

const fn row(name: &'static str, min: f64, max: f64, unit: &'static str, start: f64) -> Row {
    Row { name, min, max, unit, start }
}

/// One row for every input, in the order of [`Input`]. A board at rest with nothing connected, Z upwards.
const ROWS: [Row; Input::ALL.len()] = [
    row("asi", 0.0, 3_300.0, "V", 0.0),
    row("asi_source", 0.0, 1e9, "ohm", 0.0),
    row("accel_x", -2_000.0, 2_000.0, "g", 0.0),
    row("accel_y", -2_000.0, 2_000.0, "g", 0.0),
    row("accel_z", -2_000.0, 2_000.0, "g", 1.0),
    // In mV, as Table 2 has it.
    row("pressure", 0.0, 55_000.0, "mV", 0.0),
    row("pressure_common_mode", 0.0, 5_000.0, "V", 2.5),
    row("rail6_v", 0.0, 8_000.0, "V", 6.0),
    row("rail14_v", 0.0, 20_000.0, "V", 14.0),
    row("accel_reference", 0.0, 3_300.0, "V", 1.8),
    row("reference", 0.0, 3_300.0, "V", 0.383),
    row("internal_temperature", -55_000.0, 250_000.0, "degC", 25.0),
    row("external_temperature", -55_000.0, 250_000.0, "degC", 25.0),
    row("dsio1", 0.0, 3_300.0, "V", 0.0),
    row("dsio2", 0.0, 3_300.0, "V", 0.0),
    row("hall_supply", 0.0, 5_500.0, "V", 5.0),
];

impl Input {
    /// All of them.
    pub const ALL: [Self; 16] = [
        Self::Asi,
        Self::AsiSource,
        Self::AccelX,
        Self::AccelY,
        Self::AccelZ,
        Self::Pressure,
        Self::PressureCommonMode,
        Self::Rail6V,
        Self::Rail14V,
        Self::AccelReference,
        Self::Reference,
        Self::InternalTemperature,
        Self::ExternalTemperature,
        Self::Dsio1,
        Self::Dsio2,
        Self::HallSupply,
    ];

    fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    /// Returns its name, in lower case.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Unit of its value.
    pub fn unit(self) -> &'static str {
        self.row().unit
    }

    /// The input of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|input| input.name() == name)
    }

    /// Smallest and largest value that it takes.
    pub fn range(self) -> (f64, f64) {
        let row = self.row();
        (row.min / 1000.0, row.max / 1000.0)
    }
}

/// Resistance of the analog signal input, ohm (Table 2).
const ASI_RESISTANCE: f64 = 20_000.0;
/// Of the accelerometer, V/g.
const ACCEL_SENSITIVITY: f64 = 0.5;
/// Of the pressure amplifier (Table 2).
const PRESSURE_GAIN: f64 = 56.0;
/// Voltage that a common mode of 1 V adds to the bridge's output, V: a rejection of 80 dB, an estimate.
const COMMON_MODE_GAIN: f64 = 1e-4;
/// A digital line reads low up to this (V IL of Table 2), V.
const LOW_MAX: f64 = 1.2;
/// A digital line reads high from this on (V IH of Table 2), V.
const HIGH_MIN: f64 = 1.3;
/// Voltage that a digital line drives, V (Table 2).
const HIGH: f64 = 3.3;
/// The hall sensors need this much, V: an estimate.
const HALL_SUPPLY_MIN: f64 = 3.5;

/// 12-bit converters: volts a code. 3.3 V directly; the pressure amplifier, which has 5 V, over a divider to
/// 5.12 V; the rails over dividers to 8.192 and 20.48 V.
const DIRECT: f64 = 3.3 / 4096.0;
const PRESSURE: f64 = 5.12 / 4096.0;
const SMALL_RAIL: f64 = 8.192 / 4096.0;
const LARGE_RAIL: f64 = 20.48 / 4096.0;
/// Degrees a code of the temperature sensors.
const TEMPERATURE: f64 = 1.0 / 16.0;

/// State of the wires.
#[derive(Clone, Debug)]
pub(crate) struct Inputs {
    values: [f64; Input::ALL.len()],
    /// An external sensor is connected; without one its input follows the board's own.
    external: bool,
    outputs: DigitalOutputs,
    hall_supply_on: bool,
    /// DSIO1 and DSIO2 as read.
    levels: [bool; 2],
}

impl Inputs {
    pub(crate) fn new() -> Self {
        Self {
            values: ROWS.map(|row| row.start),
            external: false,
            outputs: DigitalOutputs::default(),
            hall_supply_on: true,
            levels: [false; 2],
        }
    }

    fn get(&self, input: Input) -> f64 {
        self.values[input as usize]
    }

    /// DSIO1 and DSIO2 on their wires, V: an output drives harder than whatever is outside.
    fn lines(&self) -> [f64; 2] {
        let DigitalOutputs { enable1, value1, enable2, value2 } = self.outputs;
        [(enable1, value1, Input::Dsio1), (enable2, value2, Input::Dsio2)].map(|(enabled, value, outside)| {
            match (enabled, value) {
                (true, true) => HIGH,
                (true, false) => 0.0,
                (false, _) => self.get(outside),
            }
        })
    }

    /// Between the thresholds a line reads as before.
    fn settle(&mut self) {
        let lines = self.lines();
        for (level, volts) in self.levels.iter_mut().zip(lines) {
            *level = volts >= HIGH_MIN || (*level && volts > LOW_MAX);
        }
    }

    pub(crate) fn halls_are_supplied(&self) -> bool {
        self.hall_supply_on && self.get(Input::HallSupply) >= HALL_SUPPLY_MIN
    }

    pub(crate) fn digital(&self) -> Lines {
        let mut lines = Lines::empty();
        lines.set(Lines::DSI1, self.levels[0]);
        lines.set(Lines::DSI2, self.levels[1]);
        lines
    }
}

impl Plant {
    /// Puts a value on an input.
    ///
    /// # Errors
    /// The wire cannot carry it: see [`Input::range`]. Nothing changes then.
    pub fn set_input(&mut self, input: Input, value: f64) -> Result<(), InputError> {
        let (min, max) = input.range();
        if !(min..=max).contains(&value) {
            return Err(InputError { input, value });
        }
        self.inputs.values[input as usize] = value;
        match input {
            Input::InternalTemperature => self.set_ambient(value),
            Input::ExternalTemperature => self.inputs.external = true,
            Input::Pressure | Input::PressureCommonMode => self.set_pressure(self.bridge()),
            Input::Dsio1 | Input::Dsio2 => self.inputs.settle(),
            Input::HallSupply => self.apply_hall_supply(),
            _ => {}
        }
        Ok(())
    }

    /// Sets the wires to the drive's digital outputs, and switches the supply of the hall sensors as the
    /// drive does.
    pub fn set_outputs(&mut self, outputs: Outputs) {
        if outputs.digital != self.inputs.outputs {
            self.inputs.outputs = outputs.digital;
            self.inputs.settle();
        }
        if outputs.hall_supply != self.inputs.hall_supply_on {
            self.inputs.hall_supply_on = outputs.hall_supply;
            self.apply_hall_supply();
        }
    }

    /// DSIO1 and DSIO2 as a voltmeter outside sees them, V.
    pub fn digital_lines(&self) -> [f64; 2] {
        self.inputs.lines()
    }

    /// The slow inputs as the board's converters tell them now.
    pub fn slow_inputs(&self) -> SlowInputs {
        let lines = self.lines();
        let inputs = &self.inputs;
        let reference = inputs.get(Input::AccelReference);
        let axis = |input| volts(reference + ACCEL_SENSITIVITY * inputs.get(input), DIRECT);
        let asi = inputs.get(Input::Asi) * ASI_RESISTANCE / (ASI_RESISTANCE + inputs.get(Input::AsiSource));
        let external = if inputs.external { inputs.get(Input::ExternalTemperature) } else { self.ambient() };
        SlowInputs {
            ambient_temperature: celsius(self.ambient()),
            external_temperature: celsius(external),
            pressure: volts(self.pressure(), PRESSURE),
            accel: [Input::AccelX, Input::AccelY, Input::AccelZ].map(axis),
            accel_reference: volts(reference, DIRECT),
            reference: volts(inputs.get(Input::Reference), DIRECT),
            rail_6v: volts(inputs.get(Input::Rail6V), SMALL_RAIL),
            rail_14v: volts(inputs.get(Input::Rail14V), LARGE_RAIL),
            asi: volts(asi, DIRECT),
            dsi1: lines.contains(Lines::DSI1),
            dsi2: lines.contains(Lines::DSI2),
        }
    }

    /// The pressure amplifier's output, V.
    fn bridge(&self) -> f64 {
        let differential = self.inputs.get(Input::Pressure) * 1e-3;
        let common = self.inputs.get(Input::PressureCommonMode) - 2.5;
        PRESSURE_GAIN * (differential + COMMON_MODE_GAIN * common)
    }
}

/// 12 bits, rounded to nearest and limited, in volts.
fn volts(value: f64, per_code: f64) -> Volts {
    let code = libm::floor(value / per_code + 0.5).clamp(0.0, 4095.0);
    Volts::from_bits((code * per_code * 65_536.0 + 0.5) as i32)
}

fn celsius(value: f64) -> Celsius {
    let code = libm::floor(value / TEMPERATURE + 0.5);
    Celsius::from_bits((code * TEMPERATURE * 65_536.0) as i32)
}
