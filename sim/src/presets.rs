//! Real motors, every figure with its source.
//!
//! What no source states is an estimate, the same for all unless said otherwise:
//!
//! - **Friction** (where a no-load current is published): the no-load torque k I0 is split in halves at the no-load
//!   speed, one Coulomb, one viscous. Bearing and hysteresis losses are about constant, windage and eddy currents
//!   grow with speed; no source splits them.
//! - **Back-EMF** of maxon motors: sinusoidal, as their slotless and flat designs are commonly taken; the catalogue
//!   prints no shape.
//! - **Thermal resistance** from winding to ambient: 100 K over the copper loss at the rated current with the
//!   winding at 125 degrees Celsius, which is how a rated current at 25 degrees Celsius ambient is defined. The
//!   time constant, 60 s, is a guess.
//! - **Cogging**: none for slotless motors; 3 % of the rated torque for slotted ones, one period per slot and pole
//!   combination of a common design.

use crate::plant::{BackEmf, MotorConfig};

/// A motor of the market.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// Short name: what `--motor` takes.
    pub name: &'static str,
    /// Who makes it.
    pub maker: &'static str,
    /// Part or order number.
    pub part: &'static str,
    /// The data for the plant.
    pub motor: MotorConfig,
    /// Published operating points.
    pub data: DataSheet,
    /// Where each figure comes from.
    pub sources: &'static [Source],
    /// What was estimated, and how.
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

/// A source and the figures taken from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// Which figures.
    pub figures: &'static str,
    /// Where they are printed.
    pub place: &'static str,
}

/// The motor of that name.
pub fn preset(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

/// What most motors have in common: copper, an estimate for the magnets, no thermal or friction data.
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

/// The motors, by name.
pub static PRESETS: [Preset; 4] = [
    Preset {
        name: "ec45-flat-50w-18v",
        maker: "maxon",
        part: "EC 45 flat 50 W, 18 V winding (651606-651609 family)",
        motor: MotorConfig {
            pole_pairs: 8,
            resistance: 0.447,
            inductance: 0.000_243,
            torque_constant: 0.0295,
            inertia: 1.35e-5,
            static_friction: 0.004_09,
            viscous_friction: 6.80e-6,
            cogging_torque: 0.0022,
            cogging_periods: 48,
            thermal_resistance: 11.9,
            ..COMMON
        },
        data: DataSheet {
            nominal_voltage: 18.0,
            no_load_speed: Some(5740.0),
            no_load_current: Some(0.277),
            rated_speed: Some(4690.0),
            rated_torque: Some(0.112),
            rated_current: Some(3.68),
        },
        sources: &[
            Source {
                figures: "nominal voltage, resistance, inductance, torque constant, inertia, no-load and rated points",
                place: "maxon catalogue page 321, EC 45 flat 50 W: https://online.flippingbook.com/view/1042987/321",
            },
            Source {
                figures: "8 pole pairs, of sibling parts",
                place: "github rauc-lab/being, being/motors/motor_paramters.py (EC45_469292_24V); github \
                        roboticslab-uc3m/soft-robotics-developer-manual, csv/soft-gripper-motor-NV.csv @a7166c8a",
            },
        ],
        estimates: &[
            "friction: halves of 0.0295 N m/A x 0.277 A at 5740 rpm",
            "back-EMF: sinusoidal",
            "cogging: 2 % of the rated torque, 48 periods (12 slots, 16 poles)",
            "thermal resistance: 100 K / (3.68 A)^2 / (0.447 ohm x 1.393)",
        ],
    },
    Preset {
        name: "ec-max40-120w-48v",
        maker: "maxon",
        part: "EC-max 40, 120 W, 283870",
        motor: MotorConfig {
            pole_pairs: 1,
            resistance: 1.03,
            inductance: 0.000_204,
            torque_constant: 0.0448,
            inertia: 1.01e-5,
            static_friction: 0.005_94,
            viscous_friction: 5.61e-6,
            thermal_resistance: 4.23,
            ..COMMON
        },
        data: DataSheet {
            nominal_voltage: 48.0,
            no_load_speed: Some(10_100.0),
            no_load_current: None,
            rated_speed: Some(9250.0),
            rated_torque: Some(0.17),
            rated_current: Some(4.06),
        },
        sources: &[Source {
            figures: "all but the no-load current; its speed constant 231 rpm/V contradicts the rest and is not used",
            place: "github paulscherrerinstitute/ecmccfg, hardware/Motors/ecmcEL7411-Motor-Maxon-283870.cmd @19fd09c5",
        }],
        estimates: &[
            "no-load current: 4.06 A - 0.17 N m / 0.0448 N m/A = 0.265 A, the rated current less what its torque takes",
            "friction: halves of 0.0448 N m/A x 0.265 A at 10 100 rpm",
            "back-EMF: sinusoidal; no cogging: a slotless winding",
            "thermal resistance: 100 K / (4.06 A)^2 / (1.03 ohm x 1.393)",
        ],
    },
    Preset {
        name: "ec90-flat-90w-24v",
        maker: "maxon",
        part: "EC 90 flat, 90 W, 323772",
        motor: MotorConfig {
            pole_pairs: 12,
            resistance: 0.363,
            inductance: 0.000_264,
            torque_constant: 0.0705,
            inertia: 3.06e-4,
            static_friction: 0.019_0,
            viscous_friction: 5.69e-5,
            cogging_torque: 0.0077,
            cogging_periods: 72,
            thermal_resistance: 6.81,
            ..COMMON
        },
        data: DataSheet {
            nominal_voltage: 24.0,
            no_load_speed: Some(3190.0),
            no_load_current: Some(0.539),
            rated_speed: Some(2650.0),
            rated_torque: Some(0.387),
            rated_current: Some(5.39),
        },
        sources: &[Source {
            figures: "all",
            place: "maxon EC catalogue p. 197 April 2006, \
                    https://mat.transtechnik.fr/LINMOT/documentation/Moteurs/EC%20Motors/Maxon/Maxon%20-%20EC_90_flat_244879.pdf, \
                    as quoted in a public file datasheets.ts",
        }],
        estimates: &[
            "friction: halves of 0.0705 N m/A x 0.539 A at 3190 rpm",
            "back-EMF: sinusoidal",
            "cogging: 2 % of the rated torque, 72 periods (18 slots, 24 poles)",
            "thermal resistance: 100 K / (5.39 A)^2 / (0.363 ohm x 1.393)",
        ],
    },
    Preset {
        name: "bly172s-24v",
        maker: "Anaheim Automation",
        part: "BLY172S-24V-4000",
        motor: MotorConfig {
            pole_pairs: 4,
            resistance: 0.768,
            inductance: 0.001_28,
            torque_constant: 0.034_43,
            inertia: 4.8e-6,
            static_friction: 0.004_82,
            viscous_friction: 1.151e-5,
            cogging_torque: 0.0024,
            cogging_periods: 24,
            thermal_resistance: 7.63,
            ..COMMON
        },
        data: DataSheet {
            nominal_voltage: 24.0,
            no_load_speed: None,
            no_load_current: None,
            rated_speed: Some(4000.0),
            rated_torque: None,
            rated_current: Some(3.5),
        },
        sources: &[
            Source {
                figures: "resistance 0.384 ohm and inductance 0.64 mH per phase (doubled), flux linkage 5.205 mV s \
                          (torque constant = 3 sqrt 3 / pi x 4 x flux), inertia",
                place: "github anyway-blows/ti-c2000-motor-control-sdk, \
                        solutions/universal_motorcontrol_lab/common/include/user_mtr1.h @b0b88fb4 (TI MotorControl SDK 3.03)",
            },
            Source {
                figures: "4 pole pairs, rated current and speed; its torque constant 0.041 is above its flux and not used",
                place: "MathWorks mcb_SetPMSMMotorParameters.m",
            },
        ],
        estimates: &[
            "no-load current: 0.28 A at 4000 rpm, 8 % of the rated current, the mean of the other three motors",
            "friction: halves of 0.03443 N m/A x 0.28 A at 4000 rpm",
            "cogging: 2 % of 0.03443 N m/A x 3.5 A, 24 periods (12 slots, 8 poles)",
            "thermal resistance: 100 K / (3.5 A)^2 / (0.768 ohm x 1.393)",
        ],
    },
];
