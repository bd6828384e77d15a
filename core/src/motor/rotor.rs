//! Where the rotor is: from the hall sensors, or, in open loop, where the field says it is; and how far it has turned.

pub mod back_emf;
pub mod hall;
pub mod hall_calibration;
pub mod listening;
pub mod open_loop;
pub mod sensorless;
pub mod zero_crossing;

use super::clock::Instant;
use super::coefficients::Coefficients;
use super::commutate::commutation::Direction;
use super::rotor::hall::{Hall, HallCoefficients, HallDiagnostics, HallEvents};
use super::rotor::open_loop::{Field, OpenLoop};
use super::sense::samples::Samples;
use crate::units::ElectricalSpeed;
use serde::{Deserialize, Serialize};

/// State of the rotor station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rotor {
    hall: Hall,
    open_loop: OpenLoop,
    turned: Turned,
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
            let ahead = sector as i32 - before as i32;
            let turned = match ahead {
                -2..=2 => ahead,
                3 | -3 if backward => -3,
                3 | -3 => 3,
                4.. => ahead - 6,
                _ => ahead + 6,
            };
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
    pub fn step(&mut self, c: &Coefficients, now: Instant, samples: &Samples) -> HallEvents {
        let events = self.hall.step(&c.hall, now, samples);
        self.count_halls(events.sectors < 0);
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
            && !matches!(self.turned.sector, Some(counted) if counted == sector)
        {
            self.turned.reach(sector, backward);
        }
    }

    /// When the hall sensors have to be asked even if their code stays.
    #[inline]
    pub const fn due(&self) -> Instant {
        self.hall.due()
    }

    /// The next tick looks at everything.
    pub const fn wake(&mut self, now: Instant) {
        self.hall.wake(now);
    }

    /// The hall lines mean something else from now on: what was measured by the old meaning is forgotten.
    pub fn change_wiring(&mut self, now: Instant, before: &HallCoefficients, after: &HallCoefficients) {
        if (before.sectors, before.offset) != (after.sectors, after.offset) {
            self.hall.forget(now);
        }
    }

    /// Open loop starts from standstill with the rotor resting at `angle` (u32 turn): a quarter turn behind it, where
    /// the field's pull is 0 and grows as it turns.
    pub fn start_open_loop(&mut self, now: Instant, angle: u32, direction: Direction) {
        const QUARTER: u32 = 1 << 30;
        self.open_loop.start(
            now,
            match direction {
                Direction::Forward => angle.wrapping_sub(QUARTER),
                Direction::Reverse => angle.wrapping_add(QUARTER),
            },
        );
    }

    /// One tick of the open-loop field; it slows to standstill unless `run`.
    pub fn step_open_loop(
        &mut self,
        c: &Coefficients,
        now: Instant,
        direction: Direction,
        run: bool,
    ) -> Field {
        self.open_loop.step(&c.open_loop, now, direction, run)
    }

    /// The field turns on at the speed that it has.
    pub fn field_is_steady(&self, c: &Coefficients, run: bool) -> bool {
        self.open_loop.is_steady(&c.open_loop, run)
    }

    /// The open-loop field stands still.
    pub const fn field_stopped(&self) -> bool {
        self.open_loop.stopped()
    }

    /// Position by the hall sensors.
    #[inline]
    pub const fn hall_position(&self, now: Instant) -> Position {
        Position { angle: self.hall.angle(now), speed: self.hall.speed() }
    }

    /// No hall edge for the time-out.
    pub const fn hall_stopped(&self) -> bool {
        self.hall.stopped()
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
    #[inline]
    pub fn hall_speed(&self, c: &Coefficients, now: Instant) -> ElectricalSpeed {
        ElectricalSpeed::from_bits(c.speed_of_turns.apply32(self.hall.speed_bounded(now)))
    }

    /// Speed as of the last edge, 2^-32 turn a tick, signed.
    #[inline]
    pub const fn hall_turns(&self) -> i32 {
        self.hall.speed()
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
    pub const fn field_angle(&self, now: Instant) -> u32 {
        self.open_loop.angle(now)
    }

    /// Frequency of the open-loop field, a magnitude, raw I16F16 electrical rev/s.
    pub const fn field_frequency(&self) -> i32 {
        self.open_loop.frequency()
    }
}
