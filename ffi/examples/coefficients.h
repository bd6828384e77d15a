/* Coefficients of a motor's control, computed by narx 0.2.0. Make them again, do not edit them. */

#include "narx.h"

#if NARX_COEFFICIENTS_VERSION != 15
#error "these coefficients were made for another version of narx: make them again"
#endif

static const narx_coefficients_t coefficients = {
    .measurement = {
        .bus_voltage = {
            .gain = 83885006,
            .offset = 0,
            .bias = 0,
        },
        .bus_current = {
            .gain = 34359738,
            .offset = 0,
            .bias = -4611685969035264,
        },
        .phase_voltage = {
            .gain = 83885006,
            .offset = 0,
            .bias = 0,
        },
        .filter = 65536,
    },
    .hall = {
        .sectors = {255, 0, 2, 1, 4, 5, 3, 255},
        .offset = 0,
        .timeout = 65536000,
        .interpolation_min = 3579137,
        .captured = true,
        .lost_after = 3,
    },
    .hall_calibration = {
        .speed = 214748,
        .level = 226492,
    },
    .open_loop = {
        .speed = 2184533,
        .rate = 715827773,
        .level_start = 226492,
        .level = 405169,
        .slope = {
            .mantissa = 702586659,
            .shift = 33,
        },
        .turns = {
            .mantissa = 879609302,
            .shift = 27,
        },
    },
    .sensorless = {
        .back_emf = {
            .terminal = {
                .gain = 83885006,
                .offset = 0,
                .bias = 0,
            },
            .noise = 4,
            .silence = 4,
            .settle = 8,
            .discard = 0,
            .earliest = 8192,
            .comparator = false,
            .delay_rising = 0,
            .delay_falling = 0,
            .back_emf = {
                .mantissa = 929259124,
                .shift = 34,
            },
            .emf_of_turns = {
                .mantissa = 567174758,
                .shift = 36,
            },
        },
        .rails = {
            .resistance = {
                .mantissa = 824633720,
                .shift = 30,
            },
            .commutation = {
                .mantissa = 1055531162,
                .shift = 38,
            },
            .back_emf = {
                .mantissa = 929259124,
                .shift = 34,
            },
            .leak = 10000,
        },
        .timeout = 32768000,
        .rest = 50,
        .align = 1430,
        .align_rate = 424096563,
        .align_level = 226492,
        .kick_rate = 132765777,
        .kick_level = 405169,
        .kick_patience = 500,
        .kick_limit = 10000,
        .brake_max = 57380719,
    },
    .protection = {
        .over_voltage = {
            .trip = 3997696,
            .clear = 3964928,
            .ticks = 100,
        },
        .over_voltage_at_once = 4063232,
        .under_voltage = {
            .trip = 1048576,
            .clear = 1081344,
            .ticks = 10,
        },
        .over_current = {
            .trip = 458752,
            .clear = 430080,
            .ticks = 3,
        },
        .over_temperature = {
            .trip = 12451840,
            .clear = 12320768,
            .ticks = 1000,
        },
        .warning = {
            .trip = 12124160,
            .clear = 11993088,
            .ticks = 1000,
        },
        .over_pressure = {
            .trip = 216269,
            .clear = 202753,
            .ticks = 100,
        },
        .overspeed_hall = {
            .trip = 21997813,
            .clear = 16921395,
            .ticks = 100,
        },
        .overspeed_sensorless = {
            .trip = 21997813,
            .clear = 16921395,
            .ticks = 100,
        },
        .shutdown_lines = 0,
        .shutdown_ticks = 10,
        .critical_mask = 4227858558,
        .hall_stall_ticks = 5000,
        .supply_low = 1179648,
        .ticks_per_ms = 2560,
    },
    .machine = {
        .open_loop_enable = false,
        .sensorless_enable = false,
        .hall_enable = true,
        .boot = 5000,
        .lock = 1500,
        .lock_level = 226492,
        .lock_rate = 401172424,
        .open_loop = 3000,
        .auto_restart = 20000,
        .fault_wait = 5000,
        .command_timeout = 2500,
        .other_source = false,
    },
    .control = {
        .ticks_per_ms = 2560,
        .track = 8192,
        .current = {
            .proportional = {
                .mantissa = 863803822,
                .shift = 29,
            },
            .integral = {
                .mantissa = 829251669,
                .shift = 33,
            },
        },
        .limits = {
            .soft_start = 196608,
            .maximum = 393216,
            .rate = 257698037,
            .phase_current_max = 560595,
            .derating_start = 12124160,
            .derating = {
                .mantissa = 858993459,
                .shift = 32,
            },
            .bridge = 2621,
        },
        .speed_rate = 2772258223,
        .slew = 327,
        .duty_min = 655,
        .dead_time = 163,
        .bus_guard = 3964928,
        .initial_level = 0,
        .levels_of_bus = false,
        .back_emf = {
            .mantissa = 929259124,
            .shift = 34,
        },
    },
    .commutator = {
        .earliest = 8192,
        .advance = 0,
    },
    .hall_mode = {
        .speed = {
            .proportional = {
                .mantissa = 539351685,
                .shift = 37,
            },
            .integral = {
                .mantissa = 693750833,
                .shift = 39,
            },
        },
        .speed_min = 2184533,
        .speed_max = 16921395,
        .duty_max = 31129,
        .sparse = false,
    },
    .sensorless_mode = {
        .speed = {
            .proportional = {
                .mantissa = 539289730,
                .shift = 37,
            },
            .integral = {
                .mantissa = 693751118,
                .shift = 39,
            },
        },
        .speed_min = 2184533,
        .speed_max = 16921395,
        .duty_max = 31129,
        .sparse = true,
    },
    .speed_of_turns = {
        .mantissa = 655360000,
        .shift = 32,
    },
    .sample_settle = 1966,
};
