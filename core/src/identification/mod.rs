//! Identification: the figures of a motor without a data sheet, measured by its drive.
//!
//! A conversation on top of a [`Master`]. It asks nothing of the drive that every drive of this protocol does
//! not offer: open loop, closed loop, the scope, and the parameters. So every limit and every fault of the
//! drive stays in force, and a master that falls silent stops the motor as ever.
//!
//! ```text
//!  hold        direct current in two phases at rising levels, each let go   -> R, L        (winding)
//!  count       a field that turns slowly, and somebody marks the turns      -> pole pairs
//!  spin, coast closed loop without sensors, then the bridge off             -> k           (coast)
//!  accelerate  a ramp of the speed, twice, with a coast between             -> J, friction (balance)
//!  calibrate   the drive's own service, where there are hall sensors        -> their wiring
//! ```
//!
//! Each step is commissioned from what the ones before have measured. At the end, and after an error, the
//! motor stands and the drive has the parameters that it had, but for the scope's and the hall sensors'.
//!
//! Pole pairs cannot be seen in volts and amperes: they are given, or counted.

mod accelerate;
mod balance;
mod channel;
mod coast;
mod commission;
mod error;
mod figures;
mod fit;
mod hold;
mod record;
mod result;
mod script;
mod spin;
mod winding;

pub use error::IdentificationError;
pub use figures::{Asked, Figure, Halls, Identified, Stage, Turned};

use crate::dictionary::{Decimal, engineering, number};
use crate::master::{JobError, Master, RequestError};
use crate::motor::guard::fault::Cause;
use balance::{Balance, Driven};
use channel::Channel;
use coast::Coast;
use heapless::Vec;
use hold::FIRST_DUTY;
use script::{Action, Script};
use winding::{Lock, Winding};

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
    /// Number of the present guess of the inertia.
    guess: usize,
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
/// Time for the last of a record, and for its answer, microseconds.
const MARGIN: u64 = 20_000;
/// Longest wait for a record, microseconds.
const PATIENCE: u64 = 5_000_000;
/// Pole pairs of a motor.
const POLE_PAIRS: core::ops::RangeInclusive<u8> = 1..=50;
/// Most starts of the stage that finds the torque constant.
const SPINS: u8 = 6;
/// Longest wait for a speed, microseconds.
const SPIN: u64 = 1_500_000;

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
            guess: 0,
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
                Err(error) => {
                    self.fail(master, error);
                    continue;
                }
            }
            if self.stage == Stage::Restores {
                return self.end.take();
            }
            self.retries = false;
            if let Err(error) = self.plan(master) {
                self.fail(master, error);
            }
        }
    }

    /// An action has failed, or a record fits no motor: another try where one may help, or the end.
    fn fail(&mut self, master: &mut Master, error: IdentificationError) {
        // Drive and bus are well, but the motor has not done what was expected.
        let of_motor = matches!(
            error,
            IdentificationError::Job(_)
                | IdentificationError::Unsteady(_)
                | IdentificationError::NotReached { .. }
        );
        let is_open_phase = is_open_phase(&error);
        match self.stage {
            Stage::Holds if is_open_phase && !self.retries => self.hold_again(master),
            Stage::Spins if of_motor && !is_open_phase && !self.retries && self.round + 1 < SPINS => {
                self.spin_again(master, error);
            }
            Stage::Accelerates if of_motor => {
                if let Err(error) = self.accelerate_again(master, error) {
                    self.finish(master, Err(error));
                }
            }
            _ => self.finish(master, Err(error)),
        }
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

    fn set(&mut self, number: u16, value: f64) -> Result<(), IdentificationError> {
        let raw = engineering::raw(number, value).map_err(IdentificationError::Value)?;
        self.script.add(&[Action::Write(number, raw as i32)]);
        Ok(())
    }
}

fn is_open_phase(error: &IdentificationError) -> bool {
    matches!(error, IdentificationError::Job(JobError::Fault { code, .. }) if *code == Cause::OpenPhase as u16)
}
