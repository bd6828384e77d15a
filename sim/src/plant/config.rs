//! Configuration of the plant. SI units; angles in electrical degrees where a name ends in `_deg`.

use super::phase::Phase;
use narx_core::commissioning::Motor;
use narx_core::motor::Board;

/// The whole plant.
#[derive(Clone, Debug, PartialEq)]
pub struct PlantConfig {
    /// The board's constants; the control core is built with the same ones.
    pub board: Board,
    /// The motor.
    pub motor: MotorConfig,
    /// Load on the shaft.
    pub load: LoadConfig,
    /// Supply of the bus.
    pub supply: SupplyConfig,
    /// Bridge and bus capacitor.
    pub inverter: InverterConfig,
    /// Hall sensors.
    pub hall: HallConfig,
    /// Analogue-to-digital converter.
    pub converter: ConverterConfig,
    /// Back-EMF comparators, none by default.
    pub comparator: Option<ComparatorConfig>,
    /// Ambient temperature, degrees Celsius.
    pub ambient: f64,
    /// Output of the pressure bridge after its amplifier, V.
    pub pressure: f64,
    /// Electrical angle at the start, degrees.
    pub angle_deg: f64,
    /// Mechanical speed at the start, rad/s.
    pub speed: f64,
    /// Seed of all noise.
    pub seed: u64,
}

impl PlantConfig {
    /// `motor` without load on a supply of `voltage` volts, everything else at its default.
    pub fn new(motor: MotorConfig, voltage: f64) -> Self {
        Self {
            board: Board::BENCH,
            motor,
            load: LoadConfig::default(),
            supply: SupplyConfig { voltage, ..SupplyConfig::default() },
            inverter: InverterConfig::default(),
            hall: HallConfig::default(),
            converter: ConverterConfig::default(),
            comparator: None,
            ambient: 25.0,
            pressure: 0.0,
            angle_deg: 0.0,
            speed: 0.0,
            seed: 1,
        }
    }
}

/// Shape of the phase back-EMF against the electrical angle.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum BackEmf {
    /// Straight flanks and a flat top of this many electrical degrees, above 0 and below 180.
    Trapezoidal {
        /// Width of the flat top, degrees; 120 is the ideal six-step motor.
        flat_top_deg: f64,
    },
    /// A sine.
    Sinusoidal,
}

/// A star-connected three-phase motor with equal phases, its data at 25 degrees Celsius.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MotorConfig {
    /// Pole pairs, 1 or more.
    pub pole_pairs: u8,
    /// Line to line, ohm, as data sheets print it; half of it is one phase's.
    pub resistance: f64,
    /// Line to line, H; half of it is one phase's.
    pub inductance: f64,
    /// Mean torque per DC ampere in ideal six-step, N m/A = V s/rad. A sinusoidal motor's line-to-line peak
    /// back-EMF is (pi / 3) times this times the speed.
    pub torque_constant: f64,
    /// Rotor, kg m2.
    pub inertia: f64,
    /// Coulomb friction, N m; holds a resting rotor up to the same torque.
    pub static_friction: f64,
    /// Viscous friction, N m s/rad.
    pub viscous_friction: f64,
    /// Shape of the back-EMF.
    pub back_emf: BackEmf,
    /// Amplitude of the cogging torque, N m.
    pub cogging_torque: f64,
    /// Cogging periods per mechanical revolution.
    pub cogging_periods: u16,
    /// Resistance drift, 1/K. Copper: 0.00393 (IEC 60028, annealed copper at 20 degrees Celsius).
    pub copper_drift: f64,
    /// Torque-constant drift, 1/K. About -0.0011 for NdFeB, -0.0004 for SmCo magnets; -0.001 is an estimate
    /// between.
    pub magnet_drift: f64,
    /// Winding to ambient, K/W; 0 keeps the winding at ambient temperature.
    pub thermal_resistance: f64,
    /// Time constant of the winding's temperature, s.
    pub thermal_time: f64,
    /// Which winding hangs at legs A, B, C.
    pub phase_order: [Phase; 3],
}

impl MotorConfig {
    /// The figures that commissioning works from.
    pub const fn figures(&self) -> Motor {
        Motor {
            pole_pairs: self.pole_pairs,
            resistance: self.resistance,
            inductance: self.inductance,
            torque_constant: self.torque_constant,
            inertia: self.inertia,
            static_friction: self.static_friction,
            viscous_friction: self.viscous_friction,
        }
    }
}

impl Default for MotorConfig {
    /// A plain 24 V motor of 4 pole pairs for tests; real ones are in `presets`.
    fn default() -> Self {
        Self {
            pole_pairs: 4,
            resistance: 0.36,
            inductance: 2e-4,
            torque_constant: 0.036,
            inertia: 4.8e-6,
            static_friction: 0.0,
            viscous_friction: 0.0,
            back_emf: BackEmf::Trapezoidal { flat_top_deg: 120.0 },
            cogging_torque: 0.0,
            cogging_periods: 24,
            copper_drift: 0.003_93,
            magnet_drift: -0.001,
            thermal_resistance: 0.0,
            thermal_time: 60.0,
            phase_order: [Phase::A, Phase::B, Phase::C],
        }
    }
}

/// A load on the shaft. All torques but that of a machine oppose the motion; the constant one also holds at
/// standstill.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LoadConfig {
    /// N m, like Coulomb friction.
    pub constant: f64,
    /// N m s/rad.
    pub viscous: f64,
    /// N m s2/rad2.
    pub quadratic: f64,
    /// kg m2, rigidly coupled.
    pub inertia: f64,
    /// Torque of a machine on the shaft, a dynamometer, N m. It acts against Forward whichever way the shaft
    /// turns, also at standstill; a negative one drives Forward.
    pub machine: f64,
}

impl LoadConfig {
    /// Largest figure of a load, in SI units: it holds every motor of this drive.
    pub const MAX: f64 = 1000.0;
}

/// The source behind the bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupplyConfig {
    /// Open-circuit voltage, V.
    pub voltage: f64,
    /// Source resistance, ohm. Below [`SupplyConfig::RESISTANCE_MIN`] it counts as that.
    pub resistance: f64,
    /// Takes current back. A power supply or a long line with a diode does not: regeneration then pumps the
    /// bus capacitor.
    pub may_sink: bool,
}

impl SupplyConfig {
    /// Smallest source resistance, that of an ideal source: 1 mV at 10 A, ohm.
    pub const RESISTANCE_MIN: f64 = 1e-4;
}

impl Default for SupplyConfig {
    fn default() -> Self {
        Self { voltage: 24.0, resistance: 0.1, may_sink: false }
    }
}

/// Bridge and bus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverterConfig {
    /// On-resistance of a switch and slope resistance of a diode, ohm.
    pub on_resistance: f64,
    /// Constant part of a body diode's drop, V.
    pub diode_drop: f64,
    /// Bus capacitance, F; 100 uF in the specification (section "Features").
    pub capacitance: f64,
    /// Conductance of the drive's own electronics at the bus, before the current shunt, S.
    pub own_conductance: f64,
}

impl Default for InverterConfig {
    /// 15 mA at 60 V, between the 10 mA cold and 20 mA hot of Table 1. On-resistance and drop of a 100 V
    /// MOSFET at 100 degrees Celsius: estimates, the specification prints none.
    fn default() -> Self {
        Self { on_resistance: 0.02, diode_drop: 0.8, capacitance: 100e-6, own_conductance: 15e-3 / 60.0 }
    }
}

/// Three hall sensors. Sensor A is high from 330 to 150 degrees, B from 90 to 270, C from 210 to 30.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HallConfig {
    /// All edges come this much later, degrees.
    pub offset_deg: f64,
    /// Placement error of each sensor, later, degrees.
    pub placement_deg: [f64; 3],
    /// Standard deviation of an edge's place, degrees.
    pub jitter_deg: f64,
    /// Distance between an edge's places forward and backward, degrees.
    pub hysteresis_deg: f64,
    /// Glitches: short pulses on a random line, per second.
    pub glitch_rate: f64,
    /// Which sensor drives lines A, B, C: row of [`HallConfig::ORDERS`], 0..=5.
    pub order: u8,
    /// Inverted lines, after `order`: bit 0 = A, bit 1 = B, bit 2 = C.
    pub polarity: u8,
}

impl HallConfig {
    /// The six permutations: the sensor (0 = A, 1 = B, 2 = C) at lines A, B, C.
    pub const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
}

/// Errors of the analogue-to-digital converter and its amplifiers; scales are in [`Board::front_end`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConverterConfig {
    /// Standard deviation of the noise, codes.
    pub noise: f64,
    /// Offset of the bus voltage channel, codes.
    pub bus_voltage_offset: f64,
    /// Offsets of the phase voltage channels, codes.
    pub phase_voltage_offset: [f64; 3],
    /// Offset of the bus current channel, codes.
    pub bus_current_offset: f64,
    /// From the bus voltage's conversion to phase C's, in 1/65 536 of a period.
    pub skew: u16,
}

impl Default for ConverterConfig {
    /// 0.7 codes of noise: an estimate for a 12-bit converter beside a switching bridge.
    fn default() -> Self {
        Self {
            noise: 0.7,
            bus_voltage_offset: 0.0,
            phase_voltage_offset: [0.0; 3],
            bus_current_offset: 0.0,
            skew: 0,
        }
    }
}

/// Comparators of the terminal voltages against their mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ComparatorConfig {
    /// From crossing to output, s.
    pub delay: f64,
    /// Total width of the hysteresis, V at the terminals.
    pub hysteresis: f64,
}
