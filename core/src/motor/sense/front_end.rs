//! The board's constants that the control core must know: converter scales, tick rate, gate timing.

use bitflags::bitflags;
use serde::{Deserialize, Serialize};

/// One channel of the analogue-to-digital converter: value = (code - `zero`) * `micro_per_code` / 1 000 000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Channel {
    /// Nominal code at 0 V or 0 A.
    pub zero: u16,
    /// Micro-units (uV or uA) of one code, 1 to [`Self::MICRO_PER_CODE_MAX`].
    pub micro_per_code: i32,
}

impl Channel {
    /// 1/16 V or A a code: a full scale of 256 V or A, far beyond this drive's ratings, which leaves the
    /// tick's arithmetic room.
    pub const MICRO_PER_CODE_MAX: i32 = 62_500;
}

/// Scales of the 12-bit converter channels that the tick reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FrontEnd {
    /// Bus voltage, uV per code.
    pub bus_voltage: Channel,
    /// Terminal voltages of the three phases against ground, uV per code.
    pub phase_voltage: Channel,
    /// DC-link current, uA per code; positive from the supply into the bridge.
    pub bus_current: Channel,
}

impl FrontEnd {
    /// Largest code of the 12-bit converter.
    pub const CODE_MAX: u16 = 4095;

    /// Voltages reach 80 V (the specification allows 60 V in, 62 V at shutdown: section 2, Table 2); the
    /// current is bidirectional and reaches 16.4 A (12 A peak: Table 1). The specification prints no scales:
    /// these are narx's own.
    pub const NARX: Self = Self {
        bus_voltage: Channel { zero: 0, micro_per_code: 19_531 },
        phase_voltage: Channel { zero: 0, micro_per_code: 19_531 },
        bus_current: Channel { zero: 2048, micro_per_code: 8_000 },
    };
}

bitflags! {
    /// Parts that a board may lack, and that its drive then refuses to use.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    pub struct Equipment: u8 {
        /// Connector for an external temperature sensor.
        const EXTERNAL_TEMPERATURE = 1 << 0;
        /// Switch for the supply of the hall sensors; without it they are always supplied.
        const HALL_SUPPLY_SWITCH = 1 << 1;
        /// DSIO1 and DSIO2 as inputs.
        const DIGITAL_INPUTS = 1 << 2;
        /// DSIO1 and DSIO2 as outputs.
        const DIGITAL_OUTPUTS = 1 << 3;
        /// Accelerometer.
        const ACCELEROMETER = 1 << 4;
        /// Pressure input.
        const PRESSURE = 1 << 5;
        /// Memory of the log.
        const LOG = 1 << 6;
    }
}

/// A board's description for the control core.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Board {
    /// Control ticks, and PWM periods, per second (Hz).
    pub tick_rate: u32,
    /// First instant of a period at which a new step can act, in 1/65 536 of the period: the sample is taken
    /// and `step` has returned.
    pub earliest: u16,
    /// Both switches of a leg stay off this long between one and the other, ns.
    pub dead_time_ns: u16,
    /// Resistance of the two switches that conduct in a step, milliohm: what the drive knows of its losses.
    pub bridge_milliohm: u16,
    /// The hall lines have time-stamping input captures.
    pub hall_capture: bool,
    /// Back-EMF comparators have time-stamping input captures; their edges take the place of the sampled
    /// back-EMF.
    pub comparator_capture: bool,
    /// Parts that not every board has.
    pub equipment: Equipment,
    /// Scales of the converter.
    pub front_end: FrontEnd,
}

impl Board {
    /// Returns whether a controller can be built for these constants at all: 1 to 100 kHz, a dead time of at
    /// most a quarter of the period, scales within [`Channel::MICRO_PER_CODE_MAX`], zeros that the converter
    /// can give.
    pub const fn is_plausible(&self) -> bool {
        const fn fits(channel: Channel) -> bool {
            channel.micro_per_code > 0
                && channel.micro_per_code <= Channel::MICRO_PER_CODE_MAX
                && channel.zero <= FrontEnd::CODE_MAX
        }
        let FrontEnd { bus_voltage, phase_voltage, bus_current } = self.front_end;
        let scaled = fits(bus_voltage) && fits(phase_voltage) && fits(bus_current);
        let timed = self.tick_rate >= 1_000 && self.tick_rate <= 100_000;
        scaled && timed && self.dead_time_ns as u64 * self.tick_rate as u64 <= 1_000_000_000 / 4
    }

    /// This board at another PWM rate, Hz. A tick takes as long as before: `earliest` stays where it was in
    /// time. `None` if that is not within the period any more.
    #[must_use]
    pub fn at_rate(self, tick_rate: u32) -> Option<Self> {
        let earliest = u64::from(self.earliest) * u64::from(tick_rate) / u64::from(self.tick_rate.max(1));
        Some(Self { tick_rate, earliest: earliest.try_into().ok()?, ..self })
    }

    /// The simulated board: 10 kHz (Table 2, switching frequency), a tick that takes at most 12.5 us, 500 ns
    /// dead time, two switches of 20 milliohm.
    pub const BENCH: Self = Self {
        tick_rate: 10_000,
        earliest: 8_192,
        dead_time_ns: 500,
        bridge_milliohm: 40,
        hall_capture: true,
        comparator_capture: false,
        equipment: Equipment::all(),
        front_end: FrontEnd::NARX,
    };
}
