/* Ready-made coefficients, as narx prints them, of the settings in blocks.c. */

static const narx_pi_ready_t pi_ready = {
    .gains = {
        .proportional = {
            .mantissa = 16384,
            .shift = 15,
        },
        .integral = {
            .mantissa = 687194767,
            .shift = 37,
        },
    },
    .minimum = 0,
    .maximum = 393216,
};
static const narx_ramp_ready_t ramp_ready = {
    .rate = 429496729,
};
static const narx_commutator_coefficients_t commutation_ready = {
    .earliest = 8192,
    .advance = 59652323,
};
static const narx_hall_ready_t hall_ready = {
    .station = {
        .sectors = {255, 0, 2, 1, 4, 5, 3, 255},
        .offset = 0,
        .timeout = 65536000,
        .interpolation_min = 429496,
        .captured = true,
        .lost_after = 3,
    },
    .speed_of_turns = {
        .mantissa = 655360000,
        .shift = 32,
    },
};
static const narx_zero_crossing_ready_t zero_crossing_ready = {
    .back_emf = {
        .terminal = {
            .gain = 83885006,
            .offset = 0,
            .bias = 0,
        },
        .noise = 4,
        .silence = 4,
        .settle = 8,
        .discard = 131072,
        .earliest = 8192,
        .comparator = false,
        .delay_rising = 0,
        .delay_falling = 0,
        .back_emf = {
            .mantissa = 0,
            .shift = 0,
        },
        .emf_of_turns = {
            .mantissa = 0,
            .shift = 0,
        },
    },
    .commutator = {
        .earliest = 8192,
        .advance = 0,
    },
    .bus_voltage = {
        .gain = 83885006,
        .offset = 0,
        .bias = 0,
    },
    .speed_of_turns = {
        .mantissa = 655360000,
        .shift = 32,
    },
    .timeout = 32768000,
};
static const narx_protection_coefficients_t fault_ready = {
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
        .trip = 851968000,
        .clear = 655360000,
        .ticks = 100,
    },
    .overspeed_sensorless = {
        .trip = 851968000,
        .clear = 655360000,
        .ticks = 100,
    },
    .shutdown_lines = 0,
    .shutdown_ticks = 10,
    .critical_mask = 4227858558,
    .hall_stall_ticks = 5000,
    .supply_low = 1179648,
    .ticks_per_ms = 2560,
};
static const narx_machine_coefficients_t state_ready = {
    .open_loop_enable = false,
    .sensorless_enable = false,
    .hall_enable = true,
    .boot = 5000,
    .lock = 1500,
    .lock_level = 0,
    .lock_rate = 0,
    .open_loop = 5000,
    .auto_restart = 20000,
    .fault_wait = 5000,
    .command_timeout = 2500,
    .other_source = false,
};
