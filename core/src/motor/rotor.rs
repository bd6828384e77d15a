//! Where the rotor is: from the hall sensors, or, in open loop, where the field says it is; and how far it has turned.

use super::coefficients::Coefficients;
use super::commutation::Direction;
use super::hall::{Hall, HallCoefficients, HallDiagnostics, HallEvents};
use super::open_loop::{Field, OpenLoop};
use super::samples::Samples;
use crate::units::ElectricalSpeed;
use serde::{Deserialize, Serialize};

/// State of the rotor station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rotor {
    hall: Hall,
    open_loop: OpenLoop,
    turned: Turned,
    /// Speed by the hall sensors as of this tick, and the 2^-32 turn a tick that it was converted from.
    hall_speed: ElectricalSpeed,
    hall_turns: i32,
}

/// Sectors turned since power-up. It follows the sector that the rotor is in, so whoever tells it may change: the hall sensors, or the
/// commutation of a rotor that they do not show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Turned {
    /// Signed, wrapping.
    sectors: i32,
    /// The sector that was reached; `None` until one is known, where the count begins.
    sector: Option<u8>,
}

impl Turned {
    /// The rotor is in `sector` (0..=5): by the shorter way, and half a revolution in the direction of motion.
    #[inline]
    const fn reach(&mut self, sector: u8, backward: bool) {
        if let Some(before) = self.sector {
            let ahead = if sector >= before { sector - before } else { sector + 6 - before };
            let forward = ahead < 3 || (ahead == 3 && !backward);
            let turned = if forward { ahead as i32 } else { ahead as i32 - 6 };
            self.sectors = self.sectors.wrapping_add(turned);
        }
        self.sector = Some(sector);
    }
}

/// A rotor position as the commutator wants it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Position {
    /// Electrical angle at this period's boundary, u32 turn.
    pub angle: u32,
    /// 2^-32 turn a tick, signed.
    pub speed: i32,
}

impl Rotor {
    /// One tick of the sensors.
    #[inline]
    pub fn step(&mut self, c: &Coefficients, samples: &Samples) -> HallEvents {
        let events = self.hall.step(&c.hall, samples);
        self.count_halls(events.sectors < 0);
        self.heed_speed(c);
        events
    }

    /// The hall sensors may show another sector.
    #[inline]
    fn count_halls(&mut self, backward: bool) {
        let shown = if self.hall.is_mute() { None } else { self.hall.sector() };
        if let Some(sector) = shown
            && shown != self.turned.sector
        {
            self.turned.reach(sector, backward);
        }
    }

    /// The bridge was commutated for a rotor in `sector` (0..=5): where the hall sensors show nothing, that is where it is.
    #[inline]
    pub const fn count_commutation(&mut self, sector: Option<u8>, backward: bool) {
        if let Some(sector) = sector
            && self.hall.is_mute()
        {
            self.turned.reach(sector, backward);
        }
    }

    /// One tick with an ordinary edge in the direction of `torque`, `ticks` after the last that was told: true. Else nothing is done.
    #[inline]
    pub fn turns(&mut self, c: &Coefficients, samples: &Samples, torque: Direction, ticks: u32) -> bool {
        if !self.hall.turns(&c.hall, samples, torque, ticks) {
            return false;
        }
        self.count_halls(matches!(torque, Direction::Reverse));
        self.heed_speed(c);
        true
    }

    /// The sensors' speed may have changed.
    #[inline]
    fn heed_speed(&mut self, c: &Coefficients) {
        let turns = self.hall.speed_bounded();
        if turns != self.hall_turns {
            self.hall_turns = turns;
            self.hall_speed = ElectricalSpeed::from_bits(c.speed_of_turns.apply32(turns));
        }
    }

    /// For how many ticks from now the hall sensors need no look, if their code stays.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub fn calm(&self, c: &Coefficients) -> u32 {
        self.hall.calm(&c.hall)
    }

    /// So many of these ticks have passed.
    pub const fn sleep(&mut self, ticks: u32) {
        self.hall.sleep(ticks);
    }

    /// The hall lines mean something else from now on: what was measured by the old meaning is forgotten.
    pub fn change_wiring(&mut self, before: &HallCoefficients, after: &HallCoefficients) {
        if (before.sectors, before.offset) != (after.sectors, after.offset) {
            self.hall.forget();
            (self.hall_speed, self.hall_turns) = (ElectricalSpeed::ZERO, 0);
        }
    }

    /// Open loop starts from standstill with the rotor resting at `angle` (u32 turn): a quarter turn behind it, where
    /// the field's pull is 0 and grows as it turns.
    pub fn start_open_loop(&mut self, angle: u32, direction: Direction) {
        const QUARTER: u32 = 1 << 30;
        self.open_loop.start(match direction {
            Direction::Forward => angle.wrapping_sub(QUARTER),
            Direction::Reverse => angle.wrapping_add(QUARTER),
        });
    }

    /// One tick of the open-loop field; it slows to standstill unless `run`.
    pub fn step_open_loop(&mut self, c: &Coefficients, direction: Direction, run: bool) -> Field {
        self.open_loop.step(&c.open_loop, direction, run)
    }

    /// The open-loop field stands still.
    pub const fn field_stopped(&self) -> bool {
        self.open_loop.stopped()
    }

    /// Position by the hall sensors.
    pub const fn hall_position(&self) -> Position {
        Position { angle: self.hall.angle(), speed: self.hall.speed() }
    }

    /// No hall edge for the time-out.
    pub const fn hall_stopped(&self, c: &Coefficients) -> bool {
        self.hall.stopped(&c.hall)
    }

    /// The hall sensors are not to be believed now.
    pub const fn hall_doubtful(&self) -> bool {
        self.hall.doubtful()
    }

    /// The hall sensors show no valid code.
    pub const fn hall_mute(&self) -> bool {
        self.hall.is_mute()
    }

    /// Speed by the hall sensors, signed.
    pub const fn hall_speed(&self) -> ElectricalSpeed {
        self.hall_speed
    }

    /// Counts of the hall sensors.
    pub const fn hall_diagnostics(&self) -> HallDiagnostics {
        self.hall.diagnostics()
    }

    /// Sectors turned since power-up, signed: by the hall sensors, or by the commutation where they show nothing.
    pub const fn sectors(&self) -> i32 {
        self.turned.sectors
    }

    /// Angle of the open-loop field, u32 turn.
    pub const fn field_angle(&self) -> u32 {
        self.open_loop.angle()
    }

    /// Frequency of the open-loop field, a magnitude, raw I16F16 electrical rev/s.
    pub const fn field_frequency(&self) -> i32 {
        self.open_loop.frequency()
    }
}
