//! Motors of maxon.

use super::{COMMON, DataSheet, Preset, Source};
use crate::plant::MotorConfig;

/// maxon EC 45 flat 50 W, 18 V winding.
pub(super) const EC45_FLAT_50W_18V: Preset = Preset {
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
};

/// maxon EC 45 flat 50 W, 36 V winding.
pub(super) const EC45_FLAT_50W_36V: Preset = Preset {
    name: "ec45-flat-50w-36v",
    maker: "maxon",
    part: "EC 45 flat 50 W, 36 V winding",
    motor: MotorConfig {
        pole_pairs: 8,
        resistance: 2.24,
        inductance: 8.68e-4,
        torque_constant: 0.055_7,
        inertia: 1.35e-5,
        static_friction: 0.004_21,
        viscous_friction: 6.63e-6,
        cogging_torque: 0.001_8,
        cogging_periods: 48,
        thermal_resistance: 12.1,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 36.0,
        no_load_speed: Some(6060.0),
        no_load_current: Some(0.151),
        rated_speed: Some(5010.0),
        rated_torque: Some(0.090_9),
        rated_current: Some(1.63),
    },
    sources: &[
        Source {
            figures: "nominal voltage, resistance, inductance, torque constant, inertia, no-load and rated points",
            place: "maxon catalogue page 321, EC 45 flat 50 W: https://online.flippingbook.com/view/1042987/321",
        },
        Source {
            figures: "8 pole pairs, of sibling parts",
            place: "github rauc-lab/being, being/motors/motor_paramters.py (EC45_469292_24V); github roboticslab-uc3m/soft-robotics-developer-manual, csv/soft-gripper-motor-NV.csv @a7166c8a",
        },
    ],
    estimates: &[
        "friction: halves of 0.0557 N m/A x 0.151 A at 6060 rpm",
        "back-EMF: sinusoidal",
        "cogging: 2 % of the rated torque, 48 periods (12 slots, 16 poles)",
        "thermal resistance: 100 K / (1.63 A)^2 / (2.24 ohm x 1.393)",
    ],
};

/// maxon EC 45 flat 70 W, 36 V winding.
pub(super) const EC45_FLAT_70W_36V: Preset = Preset {
    name: "ec45-flat-70w-36v",
    maker: "maxon",
    part: "EC 45 flat 70 W, 36 V winding",
    motor: MotorConfig {
        pole_pairs: 8,
        resistance: 1.56,
        inductance: 6.01e-4,
        torque_constant: 0.057,
        inertia: 1.81e-5,
        static_friction: 0.005_64,
        viscous_friction: 9.09e-6,
        cogging_torque: 0.002_2,
        cogging_periods: 48,
        thermal_resistance: 11.9,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 36.0,
        no_load_speed: Some(5930.0),
        no_load_current: Some(0.198),
        rated_speed: Some(5080.0),
        rated_torque: Some(0.11),
        rated_current: Some(1.97),
    },
    sources: &[
        Source {
            figures: "nominal voltage, resistance, inductance, torque constant, inertia, no-load and rated points",
            place: "maxon catalogue page 324, EC 45 flat 70 W (provisional): https://online.flippingbook.com/view/1042987/324",
        },
        Source {
            figures: "8 pole pairs, of sibling parts",
            place: "github rauc-lab/being, being/motors/motor_paramters.py (EC45_469292_24V); github roboticslab-uc3m/soft-robotics-developer-manual, csv/soft-gripper-motor-NV.csv @a7166c8a",
        },
    ],
    estimates: &[
        "friction: halves of 0.057 N m/A x 0.198 A at 5930 rpm",
        "back-EMF: sinusoidal",
        "cogging: 2 % of the rated torque, 48 periods (12 slots, 16 poles)",
        "thermal resistance: 100 K / (1.97 A)^2 / (1.56 ohm x 1.393)",
    ],
};

/// maxon EC 45 flat 70 W, 60 V winding.
pub(super) const EC45_FLAT_70W_60V: Preset = Preset {
    name: "ec45-flat-70w-60v",
    maker: "maxon",
    part: "EC 45 flat 70 W, 60 V winding",
    motor: MotorConfig {
        pole_pairs: 8,
        resistance: 7.37,
        inductance: 0.004_27,
        torque_constant: 0.152,
        inertia: 1.81e-5,
        static_friction: 0.004_33,
        viscous_friction: 1.11e-5,
        cogging_torque: 0.002_9,
        cogging_periods: 48,
        thermal_resistance: 11.5,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 60.0,
        no_load_speed: Some(3720.0),
        no_load_current: Some(0.057),
        rated_speed: Some(3010.0),
        rated_torque: Some(0.143),
        rated_current: Some(0.92),
    },
    sources: &[
        Source {
            figures: "nominal voltage, resistance, inductance, torque constant, inertia, no-load and rated points",
            place: "maxon catalogue page 324, EC 45 flat 70 W (provisional): https://online.flippingbook.com/view/1042987/324",
        },
        Source {
            figures: "8 pole pairs, of sibling parts",
            place: "github rauc-lab/being, being/motors/motor_paramters.py (EC45_469292_24V); github roboticslab-uc3m/soft-robotics-developer-manual, csv/soft-gripper-motor-NV.csv @a7166c8a",
        },
    ],
    estimates: &[
        "friction: halves of 0.152 N m/A x 0.057 A at 3720 rpm",
        "back-EMF: sinusoidal",
        "cogging: 2 % of the rated torque, 48 periods (12 slots, 16 poles)",
        "thermal resistance: 100 K / (0.92 A)^2 / (7.37 ohm x 1.393)",
    ],
};

/// maxon EC 90 flat, 90 W.
pub(super) const EC90_FLAT_90W_24V: Preset = Preset {
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
};

/// maxon EC-max 40, 120 W.
pub(super) const EC_MAX40_120W_48V: Preset = Preset {
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
};

/// maxon EC-4pole 30, 200 W, 305014.
pub(super) const EC4POLE30_200W_36V: Preset = Preset {
    name: "ec4pole30-200w-36v",
    maker: "maxon",
    part: "EC-4pole 30, 200 W, 305014",
    motor: MotorConfig {
        pole_pairs: 2,
        resistance: 0.21,
        inductance: 3.7e-5,
        torque_constant: 0.020_6,
        inertia: 3.33e-6,
        static_friction: 0.004_96,
        viscous_friction: 2.84e-6,
        thermal_resistance: 13.4,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 36.0,
        no_load_speed: Some(16_700.0),
        no_load_current: Some(0.482),
        rated_speed: Some(16_100.0),
        rated_torque: Some(0.095_2),
        rated_current: Some(5.06),
    },
    sources: &[Source {
        figures: "all",
        place: "github mzlumi/ankle-prosthesis-sea-design, data/motors/maxon_ec4pole30_305014.yaml @1c186e02, from the maxon catalogue of March 2021 p. 261",
    }],
    estimates: &[
        "friction: halves of 0.0206 N m/A x 0.482 A at 16700 rpm",
        "back-EMF: sinusoidal",
        "no cogging: a slotless winding",
        "thermal resistance: 100 K / (5.06 A)^2 / (0.21 ohm x 1.393)",
    ],
};

/// maxon EC-i 40, 100 W, 488607.
pub(super) const EC_I40_100W_48V: Preset = Preset {
    name: "ec-i40-100w-48v",
    maker: "maxon",
    part: "EC-i 40, 100 W, 488607",
    motor: MotorConfig {
        pole_pairs: 7,
        resistance: 0.994,
        inductance: 9.95e-4,
        torque_constant: 0.091,
        inertia: 4.4e-6,
        static_friction: 0.006_82,
        viscous_friction: 1.3e-5,
        cogging_torque: 0.004_5,
        cogging_periods: 84,
        thermal_resistance: 10.6,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 48.0,
        no_load_speed: Some(5000.0),
        no_load_current: Some(0.15),
        rated_speed: None,
        rated_torque: Some(0.224),
        rated_current: Some(2.61),
    },
    sources: &[Source {
        figures: "all but its stall figures, which contradict the rest",
        place: "github robomotic/mujoco-motors, motor_assets/maxon/maxon_ec_i_40_488607.json @0182469a",
    }],
    estimates: &[
        "rated current: 0.224 N m / 0.091 N m/A + 0.15 A = 2.61 A",
        "friction: halves of 0.091 N m/A x 0.15 A at 5000 rpm",
        "back-EMF: sinusoidal",
        "cogging: 2 % of the rated torque, 84 periods (12 slots, 14 poles)",
        "thermal resistance: 100 K / (2.61 A)^2 / (0.994 ohm x 1.393)",
    ],
};
