//! Real motors, every figure with its source.
//!
//! Values that no source states are estimates, the same for all unless said otherwise:
//!
//! - **Friction** (where a no-load current is published): the no-load torque k I0 is split in halves at the
//!   no-load speed, one Coulomb, one viscous. Bearing and hysteresis losses are about constant, windage and
//!   eddy currents grow with speed; no source splits them.
//! - **Back-EMF**: sinusoidal, as slotless and flat designs are commonly taken and as the sources of the
//!   others model them, unless the estimates of a motor say otherwise; no data sheet prints a shape.
//! - **Thermal resistance** from winding to ambient: 100 K over the copper loss at the rated current with the
//!   winding at 125 degrees Celsius, which is how a rated current at 25 degrees Celsius ambient is defined.
//!   The time constant, 60 s, is a guess.
//! - **Cogging**: none for slotless motors; 2 % of the rated torque for slotted ones, its periods those of a
//!   common number of slots for that number of poles.

mod faulhaber;
mod maxon;
mod others;

use crate::plant::{BackEmf, MotorConfig};

/// A motor of the market.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Short name: what `--motor` takes.
    pub name: &'static str,
    /// Manufacturer.
    pub maker: &'static str,
    /// Part or order number.
    pub part: &'static str,
    /// The data for the plant.
    pub motor: MotorConfig,
    /// Published operating points.
    pub data: DataSheet,
    /// Source of each figure.
    pub sources: &'static [Source],
    /// Estimated values, and how they were estimated.
    pub estimates: &'static [&'static str],
}

/// Published operating points; `None` where the source prints none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DataSheet {
    /// V.
    pub nominal_voltage: f64,
    /// rpm at the nominal voltage.
    pub no_load_speed: Option<f64>,
    /// A.
    pub no_load_current: Option<f64>,
    /// rpm.
    pub rated_speed: Option<f64>,
    /// N m.
    pub rated_torque: Option<f64>,
    /// A.
    pub rated_current: Option<f64>,
}

impl Preset {
    /// Rated torque, N m; where the source prints none, what the rated current (6 A, the drive's own, without
    /// one) gives beside 10 % for friction.
    pub fn rated_torque(&self) -> f64 {
        let by_current = 0.9 * self.motor.torque_constant * self.data.rated_current.unwrap_or(6.0);
        self.data.rated_torque.unwrap_or(by_current)
    }
}

/// A source and the figures taken from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// Which figures.
    pub figures: &'static str,
    /// Place where they are printed.
    pub place: &'static str,
}

/// The motor of that name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

/// Values that most motors have in common: copper, an estimate for the magnets, no thermal or friction data.
const COMMON: MotorConfig = MotorConfig {
    pole_pairs: 1,
    resistance: 0.0,
    inductance: 0.0,
    torque_constant: 0.0,
    inertia: 0.0,
    static_friction: 0.0,
    viscous_friction: 0.0,
    back_emf: BackEmf::Sinusoidal,
    cogging_torque: 0.0,
    cogging_periods: 0,
    copper_drift: 0.003_93,
    magnet_drift: -0.001,
    thermal_resistance: 0.0,
    thermal_time: 60.0,
    phase_order: [crate::plant::Phase::A, crate::plant::Phase::B, crate::plant::Phase::C],
};

/// The preset, without its texts in a program that must be small.
const fn printed(preset: Preset) -> Preset {
    if cfg!(feature = "sources") { preset } else { Preset { sources: &[], estimates: &[], ..preset } }
}

/// The motors, by maker.
pub static PRESETS: [Preset; 18] = [
    printed(maxon::EC45_FLAT_50W_18V),
    printed(maxon::EC45_FLAT_50W_36V),
    printed(maxon::EC45_FLAT_70W_36V),
    printed(maxon::EC45_FLAT_70W_60V),
    printed(maxon::EC90_FLAT_90W_24V),
    printed(maxon::EC_MAX40_120W_48V),
    printed(maxon::EC4POLE30_200W_36V),
    printed(maxon::EC_I40_100W_48V),
    printed(faulhaber::BXTH_4221_18V),
    printed(faulhaber::BXTH_4221_24V),
    printed(others::BLY172S_24V),
    printed(others::BLY171D_24V),
    printed(others::QBL5704_36V),
    printed(others::DMA0204024B101_24V),
    printed(others::BLDC_1_25_058_201_24V),
    printed(others::DB42M03_24V),
    printed(others::BM_180E_24V),
    printed(others::AM8112_0F21_48V),
];
