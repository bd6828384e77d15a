//! Motors of FAULHABER.

use super::{COMMON, DataSheet, Preset, Source};
use crate::plant::MotorConfig;

/// FAULHABER 4221G018BXTH.
pub(super) const BXTH_4221_18V: Preset = Preset {
    name: "4221g018bxth-18v",
    maker: "FAULHABER",
    part: "4221G018BXTH",
    motor: MotorConfig {
        pole_pairs: 7,
        resistance: 0.46,
        inductance: 3.96e-4,
        torque_constant: 0.029_8,
        inertia: 6.9e-6,
        static_friction: 0.002_64,
        viscous_friction: 4.41e-6,
        cogging_torque: 0.002,
        cogging_periods: 84,
        thermal_resistance: 14.1,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 18.0,
        no_load_speed: Some(5710.0),
        no_load_current: Some(0.177),
        rated_speed: Some(3980.0),
        rated_torque: Some(0.102),
        rated_current: Some(3.33),
    },
    sources: &[Source {
        figures: "all",
        place: "FAULHABER data sheet 4221...BXT H, ed. 2026-07-28, https://www.faulhaber.com/fileadmin/Import/Media/EN_4221_BXTH_DFF.pdf, as quoted in a public file datasheets.ts",
    }],
    estimates: &[
        "friction: halves of 0.0298 N m/A x 0.177 A at 5710 rpm",
        "back-EMF: sinusoidal",
        "cogging: 2 % of the rated torque, 84 periods (12 slots, 14 poles)",
        "thermal resistance: 100 K / (3.33 A)^2 / (0.46 ohm x 1.393)",
    ],
};

/// FAULHABER 4221G024BXTH.
pub(super) const BXTH_4221_24V: Preset = Preset {
    name: "4221g024bxth-24v",
    maker: "FAULHABER",
    part: "4221G024BXTH",
    motor: MotorConfig {
        pole_pairs: 7,
        resistance: 0.74,
        inductance: 6.64e-4,
        torque_constant: 0.037_7,
        inertia: 6.9e-6,
        static_friction: 0.002_62,
        viscous_friction: 4.14e-6,
        cogging_torque: 0.002_2,
        cogging_periods: 84,
        thermal_resistance: 11.8,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 24.0,
        no_load_speed: Some(6040.0),
        no_load_current: Some(0.139),
        rated_speed: Some(4380.0),
        rated_torque: Some(0.112),
        rated_current: Some(2.87),
    },
    sources: &[Source {
        figures: "all",
        place: "FAULHABER data sheet 4221...BXT H, ed. 2026-07-28, https://www.faulhaber.com/fileadmin/Import/Media/EN_4221_BXTH_DFF.pdf, as quoted in a public file datasheets.ts",
    }],
    estimates: &[
        "friction: halves of 0.0377 N m/A x 0.139 A at 6040 rpm",
        "back-EMF: sinusoidal",
        "cogging: 2 % of the rated torque, 84 periods (12 slots, 14 poles)",
        "thermal resistance: 100 K / (2.87 A)^2 / (0.74 ohm x 1.393)",
    ],
};
