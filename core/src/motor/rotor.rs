//! Position, speed and number of turns of the rotor: by the hall sensors, by the terminals, or, in open loop,
//! by the field that it follows.

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
use super::commutate::pwm::PwmCommand;
use super::guard::fault::Cause;
use super::modes::{HALL_SENSORS, OPEN_LOOP, SENSORLESS};
use super::sense::samples::Samples;
use crate::units::ElectricalSpeed;
use hall::{Hall, HallCoefficients, HallEvents};
use open_loop::OpenLoop;
use sensorless::Sensorless;
use serde::{Deserialize, Serialize};

/// The source of the rotor's position.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// The bridge is off: the hall sensors and the terminals.
    #[default]
    Both,
    /// The terminals, by their back-EMF.
    Terminals,
    /// The hall sensors.
    Halls,
    /// Nobody: it is to follow the field of open loop.
    Field,
}

/// Angle after a crossing at which the hall sensors should have shown the next sector for 20 degrees: 50
/// degrees, u32 turn.
const COMPARED: i32 = ((1_i64 << 32) * 50 / 360) as i32;
/// Angle by which hall sensors that work stay behind the terminals at most: 17 degrees, u32 turn.
const LAG: i32 = ((1_i64 << 32) * 17 / 360) as i32;
/// Angle by which they are ahead at most: 30 degrees, u32 turn. A sector shown too early is ahead by 60.
const LEAD: i32 = ((1_i64 << 32) * 30 / 360) as i32;

/// State of the rotor station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rotor {
    source: Source,
    pub(super) hall: Hall,
    pub(super) sensorless: Sensorless,
    pub(super) field: OpenLoop,
    turned: Turned,
    /// The terminals are watched beside the hall sensors that run the motor.
    accompanied: bool,
    /// The tick in which the hall sensors should show the sector that the terminals have seen.
    compared: Instant,
}

/// Sectors turned since power-up. It follows the sector that the rotor is in, so whoever tells it may change:
/// the hall sensors, or the commutation of a rotor that they do not show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Turned {
    /// Signed, wrapping.
    sectors: i32,
    /// The sector that was reached; `None` until one is known, where the count begins.
    sector: Option<u8>,
}

impl Turned {
    /// The rotor is in `sector` (0..=5): by the shorter way, and half a revolution in the direction of
    /// motion.
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
    /// From now on `source` shows where the rotor is. `accompanied`: the terminals are watched beside the
    /// hall sensors.
    pub fn follow(&mut self, now: Instant, source: Source, accompanied: bool) {
        let listened = self.listens();
        (self.source, self.accompanied) = (source, accompanied);
        self.compared = now.after(u32::MAX);
        if self.listens() && !listened {
            self.sensorless.begin_listening(now);
        }
    }

    /// The source of the rotor's position: one that this build has.
    #[inline]
    pub const fn source(&self) -> Source {
        match self.source {
            Source::Terminals if !SENSORLESS => Source::Both,
            Source::Halls if !HALL_SENSORS => Source::Both,
            Source::Field if !OPEN_LOOP => Source::Both,
            source => source,
        }
    }

    /// The hall sensors show no sector.
    #[inline]
    pub const fn is_mute(&self) -> bool {
        !HALL_SENSORS || self.hall.is_mute()
    }

    /// The terminals show something of the rotor.
    #[inline]
    const fn listens(&self) -> bool {
        SENSORLESS && (self.accompanied || matches!(self.source, Source::Both | Source::Terminals))
    }

    /// The next tick looks at everything.
    pub const fn wake(&mut self, now: Instant) {
        self.hall.wake(now);
        self.sensorless.wake();
    }

    /// The command that is in force from now on.
    #[inline]
    pub fn note(&mut self, applied: &PwmCommand) {
        if SENSORLESS {
            self.sensorless.note(applied);
        }
    }

    /// Keeps the distance of its instants below the clock's range while nothing else is asked of it.
    pub fn renew(&mut self, now: Instant) {
        if self.listens() {
            self.sensorless.renew(now);
        }
    }

    /// The terminals in one tick; `applied` was in force until this period's boundary. True if the estimate
    /// of the rotor has changed.
    #[inline]
    pub fn sense_terminals(
        &mut self,
        c: &Coefficients,
        now: Instant,
        samples: &Samples,
        bus_voltage: i32,
        applied: &PwmCommand,
        torque: Direction,
    ) -> bool {
        let changed = self.listens()
            && self.sensorless.sense(&c.sensorless, now, samples, bus_voltage, applied, torque);
        if changed && self.accompanied {
            self.compared = self.sensorless.estimator().passes(COMPARED);
        }
        changed
    }

    /// The terminals are watched beside the hall sensors that run the motor.
    #[inline]
    pub const fn is_accompanied(&self) -> bool {
        self.accompanied
    }

    /// It is time to compare the hall sensors with the terminals. True once for each crossing.
    #[inline]
    pub fn is_to_compare(&mut self, now: Instant) -> bool {
        let is_due = self.accompanied && self.compared.is_due(now);
        if is_due {
            self.compared = now.after(u32::MAX);
        }
        is_due
    }

    /// Time of the next comparison.
    #[inline]
    pub fn compared(&self, now: Instant) -> Instant {
        if self.accompanied { self.compared } else { now.after(u32::MAX) }
    }

    /// The terminals show a rotor that turns by `torque`, and the hall sensors contradict themselves or,
    /// where the two can be compared, the terminals.
    pub fn halls_fail(&self, c: &Coefficients, now: Instant, torque: Direction, compares: bool) -> bool {
        let estimator = self.sensorless.estimator();
        if !self.accompanied || !self.sensorless.is_established(&c.sensorless, now) {
            return false;
        }
        let behind = estimator.angle(now).wrapping_sub(self.hall.angle(now)) as i32;
        let agrees = (-LEAD..=LAG).contains(&torque.signed(behind)) && torque.signed(self.hall.speed()) >= 0;
        let lowest = c.sensorless_mode.speed_min / 2;
        ((compares && !agrees) || self.hall.doubtful(&c.hall))
            && torque.signed(self.speed_observed(c, now)) > lowest
    }

    /// The hall sensors show a rotor that turns by `torque`.
    pub fn halls_work(&self, c: &Coefficients, torque: Direction) -> bool {
        let doubtful = self.is_mute() || self.hall.doubtful(&c.hall);
        !doubtful && torque.signed(self.hall.speed()) > 0
    }

    /// The hall sensors in one tick.
    #[inline]
    pub fn sense_halls(&mut self, c: &Coefficients, now: Instant, samples: &Samples) -> HallEvents {
        if !HALL_SENSORS {
            return HallEvents::default();
        }
        let events = self.hall.step(&c.hall, now, samples);
        self.count_halls(events.sectors < 0);
        events
    }

    /// The hall sensors may show another sector.
    #[inline]
    fn count_halls(&mut self, backward: bool) {
        let shown = if self.is_mute() { None } else { self.hall.sector() };
        if let Some(sector) = shown
            && shown != self.turned.sector
        {
            self.turned.reach(sector, backward);
        }
    }

    /// The bridge was commutated for a rotor in `sector` (0..=5): where the hall sensors show nothing, that
    /// is where it is.
    #[inline]
    pub const fn count_commutation(&mut self, sector: Option<u8>, backward: bool) {
        if self.is_mute()
            && let Some(sector) = sector
            && !matches!(self.turned.sector, Some(counted) if counted == sector)
        {
            self.turned.reach(sector, backward);
        }
    }

    /// The hall lines mean something else from now on: what was measured by the old meaning is forgotten.
    pub fn change_wiring(&mut self, now: Instant, before: &HallCoefficients, after: &HallCoefficients) {
        if (before.sectors, before.offset) != (after.sectors, after.offset) {
            self.hall.forget(now);
        }
    }

    /// The fault of too many episodes that ended. Once the bridge is off that is over, and the next start
    /// begins with none.
    #[inline]
    pub fn fault(&self) -> Option<Cause> {
        if self.source() == Source::Terminals { self.sensorless.fault() } else { None }
    }

    /// Once a millisecond: the level of a start without sensors and the field of open loop go on. `run`: the
    /// field goes to its set speed, not to standstill. True if either has changed.
    pub fn advance(&mut self, c: &Coefficients, now: Instant, torque: Direction, run: bool) -> bool {
        match self.source() {
            Source::Both | Source::Halls => false,
            Source::Terminals => self.sensorless.advance(&c.sensorless, now),
            Source::Field => self.field.advance(&c.open_loop, now, torque, run),
        }
    }

    /// The rotor is not known to turn.
    #[inline]
    pub const fn may_stand(&self) -> bool {
        match self.source() {
            Source::Halls => self.hall.stopped(),
            Source::Terminals => !self.sensorless.is_running(),
            Source::Both | Source::Field => true,
        }
    }

    /// The rotor is known to stand: with the bridge off neither its terminals nor the hall sensors show that
    /// it turns.
    pub fn stands_still(&self, c: &Coefficients, now: Instant) -> bool {
        let silent = self.is_mute() || self.hall.stopped();
        let rests = match SENSORLESS {
            true => self.listens() && self.sensorless.observes_rest(&c.sensorless, now),
            false => self.source() == Source::Both && !self.is_mute(),
        };
        rests && silent
    }

    /// The bridge turns the rotor or holds it: it does not coast.
    pub const fn is_led(&self) -> bool {
        match self.source() {
            Source::Both => false,
            Source::Terminals => self.sensorless.is_led(),
            Source::Halls | Source::Field => true,
        }
    }

    /// Speed by whom shows it, signed, raw I16F16 electrical rev/s.
    #[inline]
    pub fn speed(&self, c: &Coefficients, now: Instant) -> i32 {
        match self.source() {
            Source::Terminals => self.speed_observed(c, now),
            Source::Both | Source::Halls | Source::Field => self.hall_speed(c, now).to_bits(),
        }
    }

    /// Speed as of the last edge or crossing, 2^-32 turn a tick.
    #[inline]
    pub const fn turns(&self) -> i32 {
        match self.source() {
            Source::Terminals => self.sensorless.estimator().speed_mean(),
            Source::Both | Source::Halls | Source::Field => self.hall.speed(),
        }
    }

    /// Speed by the hall sensors, signed.
    #[inline]
    pub fn hall_speed(&self, c: &Coefficients, now: Instant) -> ElectricalSpeed {
        ElectricalSpeed::from_bits(c.speed_of_turns.apply32(self.hall.speed_bounded(now)))
    }

    /// Speed without hall sensors, signed, raw I16F16 electrical rev/s: by the terminals, or that of the
    /// open-loop field; 0 if neither is there.
    pub fn speed_without_halls(&self, c: &Coefficients, now: Instant, torque: Direction) -> i32 {
        match self.source() {
            Source::Both | Source::Terminals => self.speed_observed(c, now),
            Source::Halls => 0,
            Source::Field => torque.signed(self.field.frequency()),
        }
    }

    /// Speed by the terminals, signed, raw I16F16 electrical rev/s.
    #[inline]
    fn speed_observed(&self, c: &Coefficients, now: Instant) -> i32 {
        if SENSORLESS { c.speed_of_turns.apply32(self.sensorless.speed(&c.sensorless, now)) } else { 0 }
    }

    /// Electrical angle at the boundary `now`, u32 turn.
    pub const fn angle(&self, now: Instant) -> u32 {
        match self.source() {
            Source::Both if self.is_mute() => self.sensorless.estimator().angle(now),
            Source::Both | Source::Halls => self.hall.angle(now),
            Source::Terminals => self.sensorless.estimator().angle(now),
            Source::Field => self.field.angle(now),
        }
    }

    /// Sectors turned since power-up, signed: by the hall sensors, or by the commutation where they show
    /// nothing.
    pub const fn sectors(&self) -> i32 {
        self.turned.sectors
    }
}
