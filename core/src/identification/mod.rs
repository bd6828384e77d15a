//! Identification: the figures of a motor without a data sheet, measured by its drive.
//!
//! A conversation on top of a [`Master`]. It asks nothing of the drive that every drive of this protocol does
//! not offer: open loop, closed loop, the scope, and the parameters. So every limit and every fault of the
//! drive stays in force, and a master that falls silent stops the motor as ever.
//!
//! ```text
//!  hold        direct current in two phases at rising levels, each let go   -> R, L       (winding)
//!  count       a field that turns slowly, and somebody marks the turns      -> pole pairs
//!  spin, coast closed loop without sensors, then the bridge off             -> k          (coast)
//!  accelerate  a ramp of the speed, twice, with a coast between             -> J, friction (acceleration)
//!  calibrate   the drive's own service, where there are hall sensors        -> their wiring
//! ```
//!
//! Each step is commissioned from what the ones before have measured. At the end, and after an error, the
//! motor stands and the drive has the parameters that it had, but for the scope's and the hall sensors'.
//!
//! Pole pairs cannot be seen in volts and amperes: they are given, or counted.

mod acceleration;
mod channel;
mod coast;
mod error;
mod figures;
mod fit;
mod record;
mod script;
mod winding;

pub use error::IdentificationError;
pub use figures::{Asked, Figure, Halls, Identified, Stage, Turned};

use crate::commissioning::{self, Commissioning, CommissioningError, Mode, Motor, Nameplate};
use crate::dictionary::{Decimal, engineering, number};
use crate::master::{JobError, Master, RequestError};
use crate::motor::Board;
use crate::motor::guard::fault::Cause;
use crate::motor::signal::Signal;
use acceleration::{Balance, Driven};
use channel::Channel;
use coast::Coast;
use core::f64::consts::TAU;
use heapless::Vec;
use libm::{fabs, fmax, fmin, round, sqrt};
use script::{Action, Script};
use winding::{Lock, OFF_TIME, ON_TIME, Winding};

type Outcome = Result<Identified, IdentificationError>;

/// The identification of one motor. Call [`step`](Self::step) whenever the master was polled or has received
/// something; it owns the master's requests, jobs and downloads until it ends.
#[derive(Clone, Debug)]
pub struct Identification {
    asked: Asked,
    stage: Stage,
    script: Script,
    found: Found,
    locks: Vec<Lock, 8>,
    /// Duty of the lock under way.
    level: f64,
    /// Rounds of this stage so far.
    round: u8,
    /// A fault is being acknowledged before another try.
    retries: bool,
    /// Tries of an acceleration that have failed.
    failed: usize,
    /// The last start of this stage that has failed.
    last: Option<IdentificationError>,
    /// Kept while the motor stops and the parameters are restored.
    end: Option<Outcome>,
}

/// Figures that are known so far.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    /// 0 before they are counted.
    pole_pairs: u8,
    /// Words of the scope's memory.
    room: u16,
    /// Of the PWM, s.
    period: f64,
    /// Ambient temperature, degrees Celsius.
    temperature: Option<f64>,
    /// V.
    supply: f64,
    /// Voltage of the bus at which the drive trips, V.
    bus_max: f64,
    /// Largest current, A.
    current: f64,
    winding: Option<Winding>,
    coast: Option<Coast>,
    /// N m/A, with its standard error.
    torque_constant: (f64, f64),
    /// Equations of the acceleration under way, and what the ones before have told.
    balance: Option<Balance>,
    driven: Option<Driven>,
    halls: Option<Halls>,
    channel: Channel,
    /// Set-point of the last run, rpm.
    speed: f64,
}

/// Name of the drive's measurement of the ambient temperature (Figure 14).
const AMBIENT: &str = "Ambient Temperature";
/// Heat in the winding at the largest current where none is given, W.
const HEAT: f64 = 6.0;
/// Largest current of the drive (Table 2), A.
const CONTINUOUS: f64 = 6.0;
/// Lowest supply of the drive (Table 2), V.
const LEAST: f64 = *commissioning::SUPPLY.start();
/// The strongest level takes this share of the largest current.
const STRONG: f64 = 0.85;
/// The bus stays this much below the voltage at which the drive trips, V.
const BELOW_TRIP: f64 = 0.3;
/// The strongest level is held again while the charge that shows L is less sure than this.
const DOUBT: f64 = 0.06;
/// Duty of the first level, and the largest.
const FIRST_DUTY: f64 = 0.01;
const LARGEST_DUTY: f64 = 0.6;
/// A rotor that is held has come to rest after this time, microseconds: the first time, and where it already
/// lies in the field.
const REST: [u64; 2] = [350_000, 120_000];
/// Time for the last of a record, and for its answer, microseconds.
const MARGIN: u64 = 20_000;
/// Longest wait for a record, microseconds.
const PATIENCE: u64 = 5_000_000;
/// Share of the supply at which back-EMF is measured: half of the nominal speed at most.
const SHARE: f64 = 0.42;
/// And the least that is enough.
const ENOUGH: f64 = 0.33;
/// Back-EMF below this share of the supply leaves room for three times the speed.
const FAINT: f64 = 0.1;
/// A set-point may be this many times slower than what commissioning allows.
const SLOWER: f64 = 3.0;
/// Pole pairs of a motor.
const POLE_PAIRS: core::ops::RangeInclusive<u8> = 1..=50;
/// While turns are counted, the field turns so many times a second: so slowly that an eye sees the mark pass.
const FIELD: f64 = 2.0;
/// A count so far from a whole number is none.
const UNCLEAR: f64 = 0.3;
/// Most starts that look for that speed.
const SPINS: u8 = 6;

/// An acceleration takes this share of the current that the winding may carry: what is measured on the way
/// lags less behind it.
const ACCELERATION_SHARE: f64 = 0.7;
/// A start takes this share of the largest current: a rotor that is held swings, and its back-EMF adds to it.
const START_SHARE: f64 = 0.6;

/// Rows of a lock's record after the stop.
const AFTER: u16 = 200;
/// Samples of a third at the speed of the stop: many show the back-EMF, few show a longer part of the coast.
const MANY_SAMPLES: f64 = 16.0;
const FEW_SAMPLES: f64 = 7.0;
/// Longest wait for a speed, microseconds.
const SPIN: u64 = 1_500_000;
/// Share by which the bridge's resistance may be off.
const BRIDGE: f64 = 0.25;

/// Most guesses of a faster motor.
const GUESSES: usize = 12;
/// The back-EMF of the coasting motor agrees with that of the driven one within this share.
const AGREES: f64 = 0.15;

/// Guesses for a motor of 20 to 200 W before anything is known: `k / sqrt(R)`, N m per root watt, and
/// `J R / k^2`, s. Both are on the safe side: a light rotor gets low gains.
const MOTOR_CONSTANT: f64 = 0.05;
const MECHANICAL_TIME: [f64; 4] = [8e-3, 24e-3, 4e-3, 60e-3];

/// Signals of a lock, of a coasting rotor and of an acceleration, in the order of their bits.
const HELD: [Signal; 3] = [Signal::BusVoltage, Signal::Duty, Signal::PeriodCurrent];
const TERMINALS: [Signal; 3] = [Signal::TerminalA, Signal::TerminalB, Signal::TerminalC];
const DRIVEN: [Signal; 4] = [Signal::SpeedSensorless, Signal::BusVoltage, Signal::BusCurrent, Signal::Duty];

impl Identification {
    /// An identification that begins with the first [`step`](Self::step). The drive must be in Standby, with
    /// the shaft at rest.
    ///
    /// # Errors
    /// Pole pairs outside 1 to 50, a current or a bridge that is no positive number, or hall sensors, or
    /// pole pairs that were not given, of a rotor that is held.
    pub fn new(asked: Asked) -> Result<Self, IdentificationError> {
        if let Some(value) = asked.pole_pairs
            && !POLE_PAIRS.contains(&value)
        {
            return Err(IdentificationError::PolePairs(value));
        }
        if let Some(value) = asked.current
            && !(value > 0.0 && value <= CONTINUOUS)
        {
            return Err(IdentificationError::Current(value));
        }
        if !(asked.bridge >= 0.0 && asked.bridge < 1.0) {
            return Err(IdentificationError::Bridge(asked.bridge));
        }
        if !asked.turn && (asked.halls || asked.pole_pairs.is_none()) {
            return Err(IdentificationError::Held);
        }
        let mut script = Script::default();
        // The sampling time of a thousand ticks tells the PWM rate to 0.01 %.
        script.add(&[
            Action::Ready,
            Action::Read(number::SCOPE_ROOM),
            Action::Read(number::OVER_VOLTAGE),
            Action::Write(number::SCOPE_PRESCALER, 1000),
            Action::Read(number::SCOPE_SAMPLING_TIME),
        ]);
        Ok(Self {
            asked,
            stage: Stage::Asks,
            script,
            found: Found { pole_pairs: asked.pole_pairs.unwrap_or(0), ..Found::default() },
            locks: Vec::new(),
            level: 0.0,
            round: 0,
            retries: false,
            failed: 0,
            last: None,
            end: None,
        })
    }

    /// Part that is under way.
    pub const fn stage(&self) -> Stage {
        self.stage
    }

    /// Returns whether [`step`](Self::step) has returned the result.
    pub fn has_ended(&self) -> bool {
        self.stage == Stage::Restores && self.end.is_none()
    }

    /// A mark on the shaft passes the same place as the last time: while the rotor turns slowly
    /// ([`Stage::Counts`]), three of these tell the pole pairs. False, and nothing happens, at any other
    /// time. now: microseconds, as of the master.
    pub fn mark(&mut self, now: u64) -> bool {
        self.script.mark(now)
    }

    /// Stops the motor, restores the parameters and ends with [`IdentificationError::Aborted`]. One that is
    /// ending goes on as it does.
    pub fn abort(&mut self, master: &mut Master) {
        if self.stage != Stage::Restores {
            self.finish(master, Err(IdentificationError::Aborted));
        }
    }

    /// Goes on; returns the result once. now: microseconds, as of the master.
    pub fn step(&mut self, master: &mut Master, now: u64) -> Option<Outcome> {
        if self.end.is_none() && self.stage != Stage::Asks && !master.is_connected(now) {
            self.finish(master, Err(IdentificationError::Lost));
        }
        loop {
            match self.script.step(master, now) {
                Ok(true) => {}
                Ok(false) => return None,
                Err(error @ IdentificationError::Request(_, RequestError::NoAnswer))
                    if self.stage == Stage::Restores =>
                {
                    self.report(error);
                    self.script.drop_all(master);
                    continue;
                }
                Err(error) if self.stage == Stage::Restores => {
                    // The other parameters are restored all the same.
                    self.report(error);
                    continue;
                }
                Err(error @ IdentificationError::Job(job))
                    if self.stage == Stage::Spins
                        && self.round + 1 < SPINS
                        && !self.retries
                        && !is_open_phase(&job) =>
                {
                    // Nothing is known of this motor yet: another start, at another speed, as if the rotor
                    // were lighter or heavier.
                    self.last = Some(error);
                    self.failed = (self.failed + 1) % MECHANICAL_TIME.len();
                    self.retries = true;
                    self.script.give_up(master);
                    self.script.record.begin(&TERMINALS, 1.0);
                    continue;
                }
                Err(IdentificationError::Job(job))
                    if self.stage == Stage::Holds && !self.retries && is_open_phase(&job) =>
                {
                    // So little current flows that the drive takes a phase for open: a higher level.
                    self.retries = true;
                    self.script.give_up(master);
                    self.script.record.begin(&HELD, 1.0);
                    continue;
                }
                Err(error) => {
                    self.retry_or_finish(master, error);
                    continue;
                }
            }
            if self.stage == Stage::Restores {
                return self.end.take();
            }
            self.retries = false;
            if let Err(error) = self.plan(master) {
                self.retry_or_finish(master, error);
            }
        }
    }

    /// An acceleration that has failed is tried again with another guess of the inertia.
    fn retry_or_finish(&mut self, master: &mut Master, error: IdentificationError) {
        let again = self.stage == Stage::Accelerates
            && self.failed + 1 < MECHANICAL_TIME.len()
            && matches!(error, IdentificationError::Job(_) | IdentificationError::Unsteady(_));
        if !again {
            return self.finish(master, Err(error));
        }
        self.failed += 1;
        (self.round, self.found.balance, self.found.driven) = (0, None, None);
        self.script.give_up(master);
    }

    /// The drive is not as it was: that is an error, unless there was one before.
    fn report(&mut self, error: IdentificationError) {
        if let Some(Ok(_)) = self.end {
            self.end = Some(Err(error));
        }
    }

    fn finish(&mut self, master: &mut Master, end: Outcome) {
        if self.stage == Stage::Asks {
            // Nothing was changed yet: a motor that somebody runs goes on.
            self.script.drop_all(master);
        } else {
            self.script.restore(master);
        }
        self.stage = Stage::Restores;
        self.end.get_or_insert(end);
    }

    /// The script is done: takes what it has brought, and writes the next one.
    fn plan(&mut self, master: &mut Master) -> Result<(), IdentificationError> {
        match self.stage {
            Stage::Asks => {
                let [room, millivolts, microseconds] = self.script.answers();
                self.found.bus_max = f64::from(millivolts) / 1e3;
                // No more is used of a larger scope, so that the figures are the same on every board.
                self.found.room = (room as u16).min(record::WORDS as u16);
                self.found.period = f64::from(microseconds) * 1e-9;
                if self.found.room < 1024 || self.found.period <= 0.0 {
                    return Err(IdentificationError::NoScope { room: self.found.room });
                }
                let temperature = master.measurements().find(AMBIENT);
                self.found.temperature = temperature.map(|seen| {
                    let Decimal { digits, exponent } = seen.value;
                    (exponent..0).fold(digits as f64, |value, _| value / 10.0)
                });
                self.stage = Stage::Holds;
                self.prepare_holds()?;
                self.hold(FIRST_DUTY)
            }
            Stage::Holds => self.held(master),
            Stage::Counts => self.counted(),
            Stage::Spins => self.spun(master),
            Stage::Accelerates => self.accelerated(master),
            Stage::Calibrates => {
                let [order, polarity, offset] = self.script.answers();
                self.found.halls = Some(Halls {
                    order: order as u8,
                    polarity: polarity as u8,
                    offset: f64::from(offset) / 100.0,
                });
                self.conclude(master);
                Ok(())
            }
            Stage::Restores => Ok(()),
        }
    }

    /// Everything that was asked for is found.
    fn conclude(&mut self, master: &mut Master) {
        if let Some(winding) = self.found.winding {
            self.finish(master, Ok(self.identified(&winding)));
        }
    }

    /// Open loop with a field that stands: direct current through two phases, as a duty of the bus.
    fn prepare_holds(&mut self) -> Result<(), IdentificationError> {
        let current = self.asked.current.unwrap_or(CONTINUOUS);
        for (number, value) in [
            (number::HALL_ENABLE, 0.0),
            (number::SENSORLESS_ENABLE, 0.0),
            (number::OPEN_LOOP_ENABLE, 1.0),
            (number::NOMINAL_SUPPLY, 0.0),
            (number::OPEN_LOOP_SPEED, 0.0),
            (number::OPEN_LOOP_RAMP, 0.1),
            (number::DUTY_MAX_SL, 95.0),
            // Every period has its pulse: nothing is sampled within it.
            (number::ON_TIME_MIN, 0.0),
            (number::PHASE_CURRENT_MAX, current),
        ] {
            self.set(number, value)?;
        }
        Ok(())
    }

    fn set(&mut self, number: u16, value: f64) -> Result<(), IdentificationError> {
        let raw = engineering::raw(number, value).map_err(IdentificationError::Value)?;
        self.script.add(&[Action::Write(number, raw as i32)]);
        Ok(())
    }

    /// Rows of a lock's record from before the stop.
    fn held_rows(&self) -> u16 {
        (self.found.room / 3).min(800) - AFTER
    }

    /// Holds the rotor at a level, records it, and lets it go.
    fn hold(&mut self, duty: f64) -> Result<(), IdentificationError> {
        let rest = REST[usize::from(self.level > 0.0)];
        self.level = duty;
        self.set(number::LOCK_DUTY, 100.0 * duty)?;
        self.set(number::OPEN_LOOP_DUTY, 100.0 * duty)?;
        let before = self.held_rows();
        let filled = (f64::from(before) * self.found.period * 1e6) as u64 + MARGIN;
        self.script.add(&[
            Action::Start(0),
            Action::Wait(rest),
            Action::arm(&HELD, before + AFTER, 1, before),
            Action::Wait(filled),
            Action::Stop,
            Action::AwaitRecord,
            Action::Download(u32::from(before + AFTER) * 3),
        ]);
        self.script.record.begin(&HELD, self.found.period);
        Ok(())
    }

    /// A lock is recorded: the next level, or R and L.
    fn held(&mut self, master: &mut Master) -> Result<(), IdentificationError> {
        let Some(lock) = Lock::of(&self.script.record, self.held_rows().into(), self.level) else {
            return self.stronger();
        };
        if self.locks.is_empty() {
            self.found.supply = lock.voltage;
        }
        // Against the noise of the mean over the record.
        if lock.current <= 5.0 * lock.noise / sqrt(f64::from(self.held_rows())) {
            return self.stronger();
        }
        // Current of the phases as far as it is known without the dead time.
        let phase = lock.current / lock.duty;
        let power = lock.voltage * lock.current;
        let limit = self.asked.current.unwrap_or(CONTINUOUS);
        // The energy that a level returns to the bus grows with its square.
        let square = |volts: f64| volts * volts;
        let rise = fmax(square(lock.raised) - square(lock.voltage), square(0.02) * lock.voltage);
        let left = fmax(square(self.found.bus_max - BELOW_TRIP) - square(lock.voltage), 0.0);
        let heat = if self.asked.current.is_none() { HEAT / power } else { f64::INFINITY };
        let room = fmin(limit / phase, sqrt(fmin(heat, left / rise)));
        if self.locks.push(lock).is_err() {
            return Err(IdentificationError::Unsteady(self.stage));
        }
        let duty = lock.level;
        let next = level(duty * fmin(STRONG * room, 3.0));
        if next > 1.15 * duty {
            return self.hold(next);
        }
        if self.locks.len() < 3 {
            return self.hold(level(0.6 * duty));
        }
        if winding::doubt(&self.locks) > DOUBT && !self.locks.is_full() {
            return self.hold(duty);
        }
        self.winding(master, fmin(limit, phase / STRONG))
    }

    /// No current was seen: the next level.
    fn stronger(&mut self) -> Result<(), IdentificationError> {
        if self.level >= 0.99 * LARGEST_DUTY {
            return Err(IdentificationError::NoMotor { duty: self.level });
        }
        self.hold(level(2.0 * self.level))
    }

    /// R and L are there.
    fn winding(&mut self, master: &mut Master, current: f64) -> Result<(), IdentificationError> {
        self.found.channel = Channel::of(&mut self.locks);
        let locks = &self.locks;
        let (low, high) = locks
            .iter()
            .fold((f64::MAX, 0.0), |(low, high), lock| (fmin(low, lock.voltage), fmax(high, lock.voltage)));
        if low < 0.85 * high {
            return Err(IdentificationError::Sags { from: high, to: low });
        }
        let winding =
            winding::solve(locks, self.found.period).ok_or(IdentificationError::Unsteady(self.stage))?;
        if winding.resistance <= self.asked.bridge {
            return Err(IdentificationError::Short { resistance: winding.resistance });
        }
        (self.found.winding, self.found.current) = (Some(winding), current);
        if !self.asked.turn {
            self.conclude(master);
            return Ok(());
        }
        if self.found.pole_pairs == 0 { self.count() } else { self.first_spin() }
    }

    /// The field turns slowly, at the last level, with one pole pair as far as the drive knows.
    fn count(&mut self) -> Result<(), IdentificationError> {
        self.stage = Stage::Counts;
        self.set(number::MOTOR_POLE_PAIRS, 1.0)?;
        self.set(number::OPEN_LOOP_SPEED, 60.0 * FIELD)?;
        self.script.add(&[Action::Start(0), Action::Count, Action::Stop]);
        Ok(())
    }

    /// The turns are marked: so many times has the field turned for each.
    fn counted(&mut self) -> Result<(), IdentificationError> {
        let counted = FIELD / f64::from(script::TURNS) * self.script.time_of_turns();
        let whole = round(counted) as u8;
        if fabs(counted - f64::from(whole)) > UNCLEAR || !POLE_PAIRS.contains(&whole) {
            return Err(IdentificationError::NotCounted { counted });
        }
        self.found.pole_pairs = whole;
        self.first_spin()
    }

    fn first_spin(&mut self) -> Result<(), IdentificationError> {
        self.stage = Stage::Spins;
        self.spin(50.0 * 60.0 / f64::from(self.found.pole_pairs), SPIN)
    }

    /// The motor as it is known, with a guess for what is not.
    fn motor(&self) -> Motor {
        let total = self.found.winding.map_or(1.0, |winding| winding.resistance);
        let (k, _) = self.found.torque_constant;
        let k = if k > 0.0 { k } else { MOTOR_CONSTANT * sqrt(total) };
        let guess = MECHANICAL_TIME[self.failed.min(MECHANICAL_TIME.len() - 1)] * k * k / total;
        let inertia = self.found.driven.map_or(guess, |driven| driven.inertia.0);
        let poles = f64::from(self.found.pole_pairs);
        let coasted = self.found.coast.map_or((0.0, 0.0), |coast| coast.friction);
        let coasted = (coasted.0 / poles * inertia, coasted.1 * inertia);
        let (static_friction, viscous_friction) = self.found.driven.map_or(coasted, |driven| driven.friction);
        Motor {
            pole_pairs: self.found.pole_pairs,
            resistance: total - self.asked.bridge,
            inductance: self.found.winding.map_or(1e-3, |winding| winding.inductance),
            torque_constant: k,
            inertia,
            static_friction,
            viscous_friction,
        }
    }

    /// Commissions the drive for the motor as it is known, and writes its parameters.
    fn commission(&mut self, mode: Mode) -> Result<Commissioning, IdentificationError> {
        let rate = round(1.0 / self.found.period) as u32;
        let board = Board::BENCH.at_rate(rate).ok_or(IdentificationError::Rate(rate))?;
        let unknown = self.found.torque_constant.0 <= 0.0;
        let mut plate = Nameplate {
            motor: self.motor(),
            rated_current: Some(ACCELERATION_SHARE * self.found.current),
            // A supply of 18 V may read a little less.
            supply: if self.found.supply > 0.99 * LEAST {
                fmax(self.found.supply, LEAST)
            } else {
                self.found.supply
            },
            open_loop_speed: None,
        };
        let most = START_SHARE * self.asked.current.unwrap_or(CONTINUOUS);
        let mut commissioning = plate.commission_within(&board, mode, None, most);
        for _ in 0..GUESSES {
            if matches!(commissioning, Err(CommissioningError::TooSlow { .. })) {
                if unknown {
                    // It was guessed too slow.
                    plate.motor.torque_constant *= 0.7;
                } else {
                    // It turns faster with less torque.
                    plate.rated_current = plate.rated_current.map(|current| current / 2.0);
                }
                commissioning = plate.commission_within(&board, mode, None, most);
            }
        }
        let mut commissioning = commissioning.map_err(IdentificationError::Commissioning)?;
        // The identification turns as slowly as the motor needs. It knows no fastest speed before that is
        // measured, and the drive gets none: a light rotor leaps when its start ends.
        let fastest = fmin(f64::from(rate) * 60.0 / (6.0 * 4.0 * f64::from(self.found.pole_pairs)), 30_000.0);
        commissioning.speed_min /= SLOWER;
        if unknown {
            commissioning.speed_max = fastest;
        }
        let parameters = &mut commissioning.parameters;
        let limits = [(number::SPEED_MIN_SL, commissioning.speed_min), (number::SPEED_MAX_SL, fastest)];
        for (number, value) in limits {
            engineering::set(parameters, number, value).map_err(IdentificationError::Value)?;
        }
        for number in commissioning::WRITTEN {
            // Before it is measured the drive must not rely on it.
            let zero = unknown && number == number::BACK_EMF_CONSTANT;
            let raw = if zero { 0 } else { commissioning.parameters.raw(number) };
            self.script.add(&[Action::Write(number, raw)]);
        }
        Ok(commissioning)
    }

    /// Turns the rotor at a speed, rpm, and records its terminals after the stop.
    fn spin(&mut self, rpm: f64, wait: u64) -> Result<(), IdentificationError> {
        let commissioning = self.commission(Mode::Sensorless)?;
        let rpm = round(fmin(fmax(rpm, commissioning.speed_min), commissioning.speed_max));
        self.found.speed = rpm;
        self.script.add(&[Action::Start(rpm as i32), Action::Settle { rpm, within: wait }]);
        self.coast(MANY_SAMPLES);
        Ok(())
    }

    /// The bridge goes off: records the terminals of the coasting rotor.
    fn coast(&mut self, samples: f64) {
        let third = 20.0 / (self.found.speed * f64::from(self.found.pole_pairs));
        let prescaler = fmax(1.0, libm::floor(third / (samples * self.found.period))) as u16;
        // The first one only shows how fast the motor may turn.
        let is_first = self.stage == Stage::Spins && self.round == 0;
        let rows = self.found.room / if is_first { 9 } else { 3 };
        self.script.add(&[
            Action::arm(&TERMINALS, rows, prescaler, 0),
            Action::Wait(MARGIN),
            Action::Stop,
            Action::AwaitRecord,
            Action::Download(u32::from(rows) * 3),
        ]);
        self.script.record.begin(&TERMINALS, f64::from(prescaler) * self.found.period);
    }

    /// A coasting rotor is recorded: a faster run, or what k is.
    fn spun(&mut self, master: &mut Master) -> Result<(), IdentificationError> {
        self.round += 1;
        let poles = f64::from(self.found.pole_pairs);
        let coast = Coast::of(&self.script.record);
        let Some(coast) = coast else {
            if self.round >= SPINS {
                let unseen = IdentificationError::NoBackEmf { rpm: self.found.speed };
                return Err(self.last.unwrap_or(unseen));
            }
            // A rotor that induces this little may turn three times as fast.
            let faint = coast::highest(&self.script.record) < FAINT * self.found.supply;
            return self.spin(if faint { 3.0 } else { 1.5 } * self.found.speed, SPIN);
        };
        self.found.torque_constant = coast.torque_constant(poles);
        let (k, _) = self.found.torque_constant;
        let emf = k * coast.speed / poles;
        let most = SHARE * self.found.supply / k * 60.0 / TAU;
        let before = self.found.speed;
        if emf < ENOUGH * self.found.supply && self.round < SPINS {
            self.spin(fmin(3.0 * before, most), SPIN)?;
            if self.found.speed > 1.1 * before {
                return Ok(());
            }
            // The drive turns no faster: this is what there is.
            self.script.drop_all(master);
        }
        (self.found.coast, self.stage, self.round, self.failed) = (Some(coast), Stage::Accelerates, 0, 0);
        self.found.speed = fmin(fmax(before, 1.0), most);
        Ok(())
    }

    /// A step of the speed up to `rpm`, recorded; then a coasting rotor, recorded.
    fn accelerate(&mut self, rpm: f64) -> Result<(), IdentificationError> {
        let commissioning = self.commission(Mode::Sensorless)?;
        let fast = round(fmin(rpm, commissioning.speed_max));
        let slow = round(fmax(fast / 3.0, commissioning.speed_min));
        if slow >= 0.8 * fast {
            return Err(IdentificationError::NoRoom { slow, fast });
        }
        self.found.speed = fast;
        // The record is as long as the ramp of the set-point, and half as much.
        let rate = engineering::value(&commissioning.parameters, number::SPEED_RATE).unwrap_or(1000.0);
        let rows = self.found.room / 4;
        let length = fmax(1.5 * (fast - slow) / rate + 0.1, 0.2);
        let prescaler = fmax(1.0, round(length / (f64::from(rows) * self.found.period))) as u16;
        self.script.add(&[
            Action::Start(slow as i32),
            Action::Settle { rpm: slow, within: SPIN },
            Action::arm_forced(&DRIVEN, rows, prescaler),
            Action::Force,
            Action::Wait(MARGIN),
            Action::Speed(fast as u16),
            Action::AwaitRecord,
            Action::Download(u32::from(rows) * 4),
        ]);
        self.script.record.begin(&DRIVEN, f64::from(prescaler) * self.found.period);
        Ok(())
    }

    /// The acceleration is recorded, then the coasting rotor: inertia and friction. Then a second
    /// acceleration, with gains that fit them.
    fn accelerated(&mut self, master: &mut Master) -> Result<(), IdentificationError> {
        let unsteady = IdentificationError::Unsteady(self.stage);
        let Found { winding: Some(winding), coast: Some(coast), channel, period, .. } = self.found else {
            return Err(unsteady);
        };
        self.round += 1;
        if self.round == 1 {
            return self.accelerate(self.found.speed);
        }
        let record = &self.script.record;
        if let Some(balance) = self.found.balance.take() {
            let coast = Coast::of(record)
                .filter(|seen| self.agrees(seen, &balance))
                .map_or(coast, |seen| coast.with(seen));
            self.found.coast = Some(coast);
            self.found.torque_constant = coast.torque_constant(self.found.pole_pairs.into());
            self.found.driven = Some(balance.solve(&coast).ok_or(unsteady)?);
            return self.accelerate(self.found.speed);
        }
        let balance = Balance::of(record, &winding, &coast, channel, self.found.pole_pairs.into(), period)
            .ok_or(unsteady)?;
        if !self.agrees(&coast, &balance) {
            return Err(unsteady);
        }
        let Some(before) = self.found.driven else {
            self.found.balance = Some(balance);
            self.script.add(&[Action::Settle { rpm: self.found.speed, within: SPIN }]);
            self.coast(FEW_SAMPLES);
            return Ok(());
        };
        self.found.driven = Some(before.mean(balance.solve(&coast).ok_or(unsteady)?));
        if !self.asked.halls {
            self.conclude(master);
            return Ok(());
        }
        self.stage = Stage::Calibrates;
        self.script.add(&[Action::Stop]);
        self.commission(Mode::Hall)?;
        self.script.add(&[
            Action::CalibrateHall,
            Action::Read(number::HALL_ORDER),
            Action::Read(number::HALL_POLARITY),
            Action::Read(number::HALL_OFFSET_ANGLE),
        ]);
        Ok(())
    }

    /// Two ways to the same constant: what was recorded fits a motor if they agree.
    fn agrees(&self, coast: &Coast, balance: &Balance) -> bool {
        let (constant, _) = coast.torque_constant(self.found.pole_pairs.into());
        fabs(constant - balance.torque_constant) <= AGREES * balance.torque_constant
    }

    /// The result, from everything that was found.
    fn identified(&self, winding: &Winding) -> Identified {
        let Found { supply, current, .. } = self.found;
        let resistance = winding.resistance - self.asked.bridge;
        Identified {
            pole_pairs: self.found.pole_pairs,
            temperature: self.found.temperature,
            supply,
            current,
            resistance: Figure {
                value: resistance,
                uncertainty: fmax(0.01, winding.spread.0) * resistance + BRIDGE * self.asked.bridge,
            },
            inductance: Figure {
                value: winding.inductance,
                uncertainty: (0.05 + winding.spread.1 + 2.0 * winding::doubt(&self.locks))
                    * winding.inductance,
            },
            turned: self.turned(),
            halls: self.found.halls,
        }
    }

    fn turned(&self) -> Option<Turned> {
        let driven = self.found.driven?;
        let (k, error) = self.found.torque_constant;
        let relative = |value: f64, uncertainty: f64| Figure { value, uncertainty: uncertainty * value };
        let (inertia, uncertainty) = driven.inertia;
        let ((static_friction, viscous_friction), (speed, unsure)) = (driven.friction, driven.known);
        Some(Turned {
            torque_constant: Figure { value: k, uncertainty: 0.015 * k + 3.0 * error },
            inertia: relative(inertia, uncertainty),
            friction: relative(static_friction + viscous_friction * speed, unsure),
            static_friction,
            viscous_friction,
            speed,
        })
    }
}

/// The largest level up to this duty at which it is known when the drive reads the current.
fn level(duty: f64) -> f64 {
    if (OFF_TIME..ON_TIME).contains(&duty) { OFF_TIME } else { fmin(duty, LARGEST_DUTY) }
}

fn is_open_phase(error: &JobError) -> bool {
    matches!(error, JobError::Fault { code, .. } if *code == Cause::OpenPhase as u16)
}
