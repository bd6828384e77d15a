//! Motors of makers of whom we have one or two.

use super::{COMMON, DataSheet, Preset, Source};
use crate::plant::{BackEmf, MotorConfig};

/// Anaheim Automation BLY172S-24V-4000.
pub(super) const BLY172S_24V: Preset = Preset {
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
};

/// Anaheim Automation BLY171D-24V-4000.
pub(super) const BLY171D_24V: Preset = Preset {
    name: "bly171d-24v",
    maker: "Anaheim Automation",
    part: "BLY171D-24V-4000",
    motor: MotorConfig {
        pole_pairs: 4,
        resistance: 1.5,
        inductance: 0.002_1,
        torque_constant: 0.034_65,
        inertia: 2.4e-6,
        static_friction: 0.002_49,
        viscous_friction: 5.96e-6,
        cogging_torque: 0.001_2,
        cogging_periods: 24,
        thermal_resistance: 14.8,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 24.0,
        no_load_speed: None,
        no_load_current: None,
        rated_speed: Some(4000.0),
        rated_torque: None,
        rated_current: Some(1.8),
    },
    sources: &[Source {
        figures: "resistance and inductance per phase (doubled), flux linkage 5.238 mV s (torque constant = 3 sqrt 3 / pi x 4 x flux), inertia, rated current and speed; its printed torque constant 0.03396 is 2 % below its flux and not used",
        place: "MathWorks mcb_SetPMSMMotorParameters.m",
    }],
    estimates: &[
        "no-load current: 0.144 A at 4000 rpm, 8 % of the rated current, the mean of the motors whose makers print both",
        "friction: halves of 0.03465 N m/A x 0.144 A at 4000 rpm",
        "back-EMF: sinusoidal, as in the source's model",
        "cogging: 2 % of 0.03465 N m/A x 1.8 A, 24 periods (12 slots, 8 poles)",
        "thermal resistance: 100 K / (1.8 A)^2 / (1.5 ohm x 1.393)",
    ],
};

/// Trinamic QBL5704-94-04-032.
pub(super) const QBL5704_36V: Preset = Preset {
    name: "qbl5704-36v",
    maker: "Trinamic",
    part: "QBL5704-94-04-032",
    motor: MotorConfig {
        pole_pairs: 2,
        resistance: 0.45,
        inductance: 0.001_4,
        torque_constant: 0.063,
        inertia: 1.73e-5,
        static_friction: 0.012_8,
        viscous_friction: 3.05e-5,
        back_emf: BackEmf::Trapezoidal { flat_top_deg: 120.0 },
        cogging_torque: 0.006_4,
        cogging_periods: 12,
        thermal_resistance: 6.18,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 36.0,
        no_load_speed: None,
        no_load_current: None,
        rated_speed: Some(4000.0),
        rated_torque: Some(0.32),
        rated_current: Some(5.08),
    },
    sources: &[Source {
        figures: "all",
        place: "QBL5704 data sheet V1.05, https://www.scribd.com/document/662266484/QBL5704-Datasheet-Rev1-05, as quoted in a public file",
    }],
    estimates: &[
        "no-load current: 0.406 A at 4000 rpm, 8 % of the rated current, the mean of the motors whose makers print both",
        "friction: halves of 0.063 N m/A x 0.406 A at 4000 rpm",
        "back-EMF: trapezoidal, as motors made for block commutation",
        "cogging: 2 % of the rated torque, 12 periods (12 slots, 4 poles)",
        "thermal resistance: 100 K / (5.08 A)^2 / (0.45 ohm x 1.393)",
    ],
};

/// Hurst DMA0204024B101 (AC300022).
pub(super) const DMA0204024B101_24V: Preset = Preset {
    name: "dma0204024b101-24v",
    maker: "Hurst",
    part: "DMA0204024B101 (AC300022)",
    motor: MotorConfig {
        pole_pairs: 5,
        resistance: 0.57,
        inductance: 6.4e-4,
        torque_constant: 0.059_2,
        inertia: 1.77e-5,
        static_friction: 0.008_05,
        viscous_friction: 2.74e-5,
        cogging_torque: 0.004,
        cogging_periods: 60,
        thermal_resistance: 10.9,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 24.0,
        no_load_speed: None,
        no_load_current: None,
        rated_speed: Some(2804.0),
        rated_torque: None,
        rated_current: Some(3.4),
    },
    sources: &[
        Source {
            figures: "resistance, inductance, torque constant, inertia, pole pairs; other sources print 6 % to 18 % more back-EMF",
            place: "Hurst DMA0204024B101 BLDC Motor DataSheet, https://ww1.microchip.com/downloads/en/DeviceDoc/Hurst%20DMA0204024B101%20BLDC%20Motor%20DataSheet.pdf, as quoted in a public file",
        },
        Source {
            figures: "rated speed and current",
            place: "Microchip PMSM userparams and hurst300.h (public files)",
        },
    ],
    estimates: &[
        "no-load current: 0.272 A at 2804 rpm, 8 % of the rated current, the mean of the motors whose makers print both",
        "friction: halves of 0.0592 N m/A x 0.272 A at 2804 rpm",
        "back-EMF: sinusoidal",
        "cogging: 2 % of 0.0592 N m/A x 3.4 A, 60 periods (12 slots, 10 poles)",
        "thermal resistance: 100 K / (3.4 A)^2 / (0.57 ohm x 1.393)",
    ],
};

/// Bühler BLDC 1.25.058.201.
pub(super) const BLDC_1_25_058_201_24V: Preset = Preset {
    name: "bldc-1-25-058-201-24v",
    maker: "Bühler",
    part: "BLDC 1.25.058.201",
    motor: MotorConfig {
        pole_pairs: 4,
        resistance: 0.2,
        inductance: 6.0e-4,
        torque_constant: 0.049_62,
        inertia: 1.77e-5,
        static_friction: 0.015_9,
        viscous_friction: 4.74e-5,
        cogging_torque: 0.005_8,
        cogging_periods: 24,
        thermal_resistance: 5.61,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 24.0,
        no_load_speed: None,
        no_load_current: None,
        rated_speed: Some(3200.0),
        rated_torque: Some(0.29),
        rated_current: Some(8.0),
    },
    sources: &[Source {
        figures: "resistance and inductance per phase (doubled), flux linkage 7.5 mV s (torque constant = 3 sqrt 3 / pi x 4 x flux), inertia, rated point",
        place: "UltraZohm-style init scripts for Bühler BLDC_1_25_058_201 (public files)",
    }],
    estimates: &[
        "no-load current: 0.64 A at 3200 rpm, 8 % of the rated current, the mean of the motors whose makers print both",
        "friction: halves of 0.04962 N m/A x 0.64 A at 3200 rpm",
        "back-EMF: sinusoidal, as in the source's model",
        "cogging: 2 % of the rated torque, 24 periods (12 slots, 8 poles)",
        "thermal resistance: 100 K / (8 A)^2 / (0.2 ohm x 1.393)",
    ],
};

/// Nanotec DB42M03.
pub(super) const DB42M03_24V: Preset = Preset {
    name: "db42m03-24v",
    maker: "Nanotec",
    part: "DB42M03",
    motor: MotorConfig {
        pole_pairs: 4,
        resistance: 0.9,
        inductance: 0.001_34,
        torque_constant: 0.039_7,
        inertia: 1.1e-5,
        static_friction: 0.005_56,
        viscous_friction: 1.33e-5,
        cogging_torque: 0.002_8,
        cogging_periods: 24,
        thermal_resistance: 6.51,
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
            figures: "resistance and inductance per phase (doubled), flux linkage 6 mV s (torque constant = 3 sqrt 3 / pi x 4 x flux), inertia, rated speed and current; its no-load speed of 6000 rpm is above what its flux allows at 24 V and not used",
            place: "Infineon/Cypress pmsm_foc_motor_NANOTEC_MOTOR_DB42M03.h",
        },
        Source {
            figures: "4 pole pairs",
            place: "github theoutfield/sc_sncn_motorcontrol, examples/configuration_parameters/motor_configs @5e54d571 (Synapticon)",
        },
    ],
    estimates: &[
        "no-load current: 0.28 A at 4000 rpm, 8 % of the rated current, the mean of the motors whose makers print both",
        "friction: halves of 0.0397 N m/A x 0.28 A at 4000 rpm",
        "back-EMF: sinusoidal, as in the source's model",
        "cogging: 2 % of 0.0397 N m/A x 3.5 A, 24 periods (12 slots, 8 poles)",
        "thermal resistance: 100 K / (3.5 A)^2 / (0.9 ohm x 1.393)",
    ],
};

/// Adlee BM-180E.
pub(super) const BM_180E_24V: Preset = Preset {
    name: "bm-180e-24v",
    maker: "Adlee",
    part: "BM-180E",
    motor: MotorConfig {
        pole_pairs: 4,
        resistance: 0.291_6,
        inductance: 2.71e-4,
        torque_constant: 0.080_78,
        inertia: 1.71e-4,
        static_friction: 0.030_1,
        viscous_friction: 1.43e-4,
        cogging_torque: 0.015,
        cogging_periods: 24,
        thermal_resistance: 2.85,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 24.0,
        no_load_speed: None,
        no_load_current: None,
        rated_speed: Some(2000.0),
        rated_torque: None,
        rated_current: Some(9.3),
    },
    sources: &[Source {
        figures: "resistance and inductance per phase (doubled), flux linkage 12.21 mV s (torque constant = 3 sqrt 3 / pi x 4 x flux), inertia, rated speed and current",
        place: "MathWorks mcb_SetPMSMMotorParameters.m",
    }],
    estimates: &[
        "nominal voltage: 24 V, the next usual one above 0.08078 x 209 rad/s + 9.3 A x 0.2916 ohm = 19.6 V",
        "no-load current: 0.744 A at 2000 rpm, 8 % of the rated current, the mean of the motors whose makers print both",
        "friction: halves of 0.08078 N m/A x 0.744 A at 2000 rpm",
        "back-EMF: sinusoidal, as in the source's model",
        "cogging: 2 % of 0.08078 N m/A x 9.3 A, 24 periods (12 slots, 8 poles)",
        "thermal resistance: 100 K / (9.3 A)^2 / (0.2916 ohm x 1.393)",
    ],
};

/// Beckhoff AM8112-0F21, with brake.
pub(super) const AM8112_0F21_48V: Preset = Preset {
    name: "am8112-0f21-48v",
    maker: "Beckhoff",
    part: "AM8112-0F21, with brake",
    motor: MotorConfig {
        pole_pairs: 3,
        resistance: 1.25,
        inductance: 7.0e-4,
        torque_constant: 0.064_48,
        inertia: 7.5e-6,
        static_friction: 0.016_4,
        viscous_friction: 2.2e-5,
        cogging_torque: 0.008_2,
        cogging_periods: 18,
        thermal_resistance: 1.42,
        ..COMMON
    },
    data: DataSheet {
        nominal_voltage: 48.0,
        no_load_speed: None,
        no_load_current: None,
        rated_speed: None,
        rated_torque: None,
        rated_current: Some(6.36),
    },
    sources: &[Source {
        figures: "nominal voltage, resistance, inductance, flux linkage 12.99 mV s (torque constant = 3 sqrt 3 / pi x 3 x flux), inertia with brake, peak value of the rated current",
        place: "github paulscherrerinstitute/ecmccfg, hardware/Motors/ecmcEL7211-0010-Motor-Beckhoff-AM8112-0F21-0000.cmd @19fd09c5 (electronic name plate 0x9009)",
    }],
    estimates: &[
        "no-load current: 0.509 A at 7109 rpm, 8 % of the rated current, the mean of the motors whose makers print both",
        "friction: halves of 0.06448 N m/A x 0.509 A at 7109 rpm",
        "back-EMF: sinusoidal, as in the source's model",
        "cogging: 2 % of 0.06448 N m/A x 6.36 A, 18 periods (9 slots, 6 poles)",
        "thermal resistance: 100 K / (6.36 A)^2 / (1.25 ohm x 1.393)",
    ],
};
