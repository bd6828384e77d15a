//! A commissioned drive on a bench with its master: what a notebook or a page plays with.

use crate::bench::{Bench, BenchConfig};
use crate::plant::{LoadConfig, MotorConfig, PlantConfig, SupplyConfig};
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use core::ops::RangeInclusive;
use narx_core::bus::Frame;
use narx_core::commissioning::{Commissioning, CommissioningError, Mode, Nameplate};
use narx_core::dictionary::engineering::{self, ValueError};
#[cfg(feature = "update")]
use narx_core::master::Image;
use narx_core::master::{Config, Job, Master, NotTaken};
use narx_core::motor::{Board, State};

/// PWM frequencies that the bench's board can have, Hz; every period has one control tick.
pub const PWM_RATES: RangeInclusive<u32> = 8_000..=50_000;

/// The bench's board at this PWM rate, Hz; `None` outside of [`PWM_RATES`].
pub fn board_at(pwm_rate: u32) -> Option<Board> {
    Board::BENCH.at_rate(pwm_rate).filter(|_| PWM_RATES.contains(&pwm_rate))
}

/// Parses a PWM rate, Hz; returns the bench's board at this rate.
///
/// # Errors
/// Fails unless the text is a whole number within [`PWM_RATES`].
pub fn parse_board(pwm_rate: &str) -> Result<Board, PwmRateError> {
    pwm_rate.parse().ok().and_then(board_at).ok_or(PwmRateError)
}

/// Refusal of a PWM rate. Its text states the rates that are allowed; the caller names the argument and its
/// value before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PwmRateError;

impl fmt::Display for PwmRateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "must be a whole number from {} to {} Hz", PWM_RATES.start(), PWM_RATES.end())
    }
}

impl core::error::Error for PwmRateError {}

/// Configuration of a session: the bench, and the set-up of the drive.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SessionConfig {
    /// The motor.
    pub motor: MotorConfig,
    /// Its rated DC current, A; without it [`Nameplate::rated_current()`] estimates one.
    pub rated_current: Option<f64>,
    /// Largest set-point, mechanical rpm, as in [`Nameplate::commission_on`]; without it commissioning
    /// finds it.
    pub speed_max: Option<f64>,
    /// Board of the drive: see [`board_at`].
    #[cfg_attr(feature = "serde", serde(rename = "pwm_rate", with = "pwm_rate"))]
    pub board: Board,
    /// Load that the motor drives.
    pub load: LoadConfig,
    /// Supply voltage, V.
    pub supply: f64,
    /// Control mode.
    pub mode: Mode,
    /// Mechanical speed of open loop, rpm; without it the slowest closed-loop speed.
    pub open_loop_speed: Option<f64>,
    /// Hall sensors come this much late, electrical degrees; commissioning does not know it.
    pub hall_offset_deg: f64,
    /// Parameters by number, in their units, that win over those of commissioning.
    pub parameters: Vec<(u16, f64)>,
    /// Ambient temperature, degrees Celsius.
    pub ambient: f64,
    /// Seed of all noise.
    pub seed: u64,
    /// Goes into recordings.
    pub label: String,
    /// Keep a row per tick.
    pub trace: bool,
}

impl SessionConfig {
    /// `motor` without load on a supply of `supply` volts, at 25 degrees Celsius, with a trace.
    pub const fn new(motor: MotorConfig, supply: f64, mode: Mode) -> Self {
        Self {
            motor,
            rated_current: None,
            speed_max: None,
            board: Board::BENCH,
            load: LoadConfig { constant: 0.0, viscous: 0.0, quadratic: 0.0, inertia: 0.0, machine: 0.0 },
            supply,
            mode,
            open_loop_speed: None,
            hall_offset_deg: 0.0,
            parameters: Vec::new(),
            ambient: 25.0,
            seed: 1,
            label: String::new(),
            trace: true,
        }
    }

    /// The parameter set that the drive will have, and what limits it.
    ///
    /// # Errors
    /// A motor or supply that the drive cannot run, or a parameter that cannot have its value.
    pub fn commission(&self) -> Result<Commissioning, SessionError> {
        let motor = MotorConfig { inertia: self.motor.inertia + self.load.inertia, ..self.motor };
        let plate = Nameplate {
            motor: motor.figures(),
            rated_current: self.rated_current,
            supply: self.supply,
            open_loop_speed: self.open_loop_speed,
        };
        let mut commissioning = plate.commission_on(&self.board, self.mode, self.speed_max)?;
        for (number, value) in &self.parameters {
            engineering::enter(&mut commissioning.parameters, *number, *value)?;
        }
        Ok(commissioning)
    }

    /// Powers up a commissioned drive with nobody else on its bus.
    ///
    /// # Errors
    /// As [`commission`](Self::commission).
    pub fn power_up(&self) -> Result<(Bench, Commissioning), SessionError> {
        let commissioning = self.commission()?;
        let mut plant = PlantConfig::new(self.motor, self.supply);
        plant.board = self.board;
        plant.load = self.load;
        plant.supply = SupplyConfig { voltage: self.supply, ..plant.supply };
        plant.hall.offset_deg = self.hall_offset_deg;
        plant.ambient = self.ambient;
        plant.seed = self.seed;
        // No position is special; this one is not on a sector's edge.
        plant.angle_deg = 77.0;
        let bench = Bench::new(&BenchConfig {
            plant,
            parameters: commissioning.parameters.clone(),
            label: self.label.clone(),
            trace: self.trace,
        });
        Ok((bench, commissioning))
    }
}

/// The board, written as its PWM rate, Hz.
#[cfg(feature = "serde")]
mod pwm_rate {
    use super::{Board, PwmRateError, board_at};
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer>(board: &Board, to: S) -> Result<S::Ok, S::Error> {
        board.tick_rate.serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Board, D::Error> {
        board_at(u32::deserialize(from)?).ok_or_else(|| D::Error::custom(PwmRateError))
    }
}

/// Reason why a session cannot be built.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SessionError {
    /// The motor cannot be commissioned.
    Commissioning(CommissioningError),
    /// A parameter cannot have its value.
    Parameter(ValueError),
}

impl From<CommissioningError> for SessionError {
    fn from(error: CommissioningError) -> Self {
        Self::Commissioning(error)
    }
}

impl From<ValueError> for SessionError {
    fn from(error: ValueError) -> Self {
        Self::Parameter(error)
    }
}

impl fmt::Display for SessionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Commissioning(error) => error.fmt(f),
            Self::Parameter(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for SessionError {}

/// A bench and, at its host's place, the master. What else wants to see frames monitors them.
#[derive(Clone, Debug)]
pub struct Session {
    bench: Bench,
    master: Master,
    commissioning: Commissioning,
    /// The speed of a start that the drive is not ready for, rpm.
    start: Option<i32>,
    /// Time at which the drive will have received two of the master's requests for Standby, ns.
    ready: u64,
    /// Until then the master sends nothing unless it is told to, or receives a frame, microseconds.
    silent_until: u64,
    /// The image of the master's update.
    #[cfg(feature = "update")]
    image: Vec<u8>,
}

impl Session {
    /// Powers up a commissioned drive. The master asks for Standby; it reads no parameters unless it is told
    /// to.
    ///
    /// # Errors
    /// As [`SessionConfig::commission`].
    pub fn new(config: &SessionConfig) -> Result<Self, SessionError> {
        let (bench, commissioning) = config.power_up()?;
        let addresses = bench.node().addresses();
        let mut master = Master::new(Config { addresses, read_parameters: false, ..Config::default() });
        master.stop();
        Ok(Self {
            bench,
            master,
            commissioning,
            start: None,
            ready: 0,
            silent_until: 0,
            #[cfg(feature = "update")]
            image: Vec::new(),
        })
    }

    /// Returns this session with a bench that records nothing, as [`Bench::without_recording`].
    #[must_use]
    pub fn without_recording(self) -> Self {
        Self { bench: self.bench.without_recording(), ..self }
    }

    /// Asks for a speed, rpm, negative in reverse. A drive that boots would spend the request (it takes no
    /// start from before Standby), so it is then asked once it has been in Standby for two of the master's
    /// periods.
    pub const fn start(&mut self, rpm: i32) {
        self.start = Some(rpm);
    }

    /// Begins a job of the master. A start is that of [`Session::start`].
    ///
    /// # Errors
    /// None: the master is not silent.
    pub fn begin(&mut self, job: Job) -> Result<(), NotTaken> {
        match job {
            Job::Start { rpm } => {
                self.start(rpm);
                self.master().begin(Job::AwaitStart { rpm })
            }
            job => {
                if !job.is_record() {
                    self.start = None;
                }
                self.master().begin(job)
            }
        }
    }

    /// Asks for another speed in the direction of [`Session::start`], rpm.
    pub fn set_speed(&mut self, rpm: u16) {
        match &mut self.start {
            Some(start) => *start = start.signum() * i32::from(rpm),
            None => self.master().set_speed(rpm),
        }
    }

    /// Asks for Standby.
    pub fn stop(&mut self) {
        self.start = None;
        self.master().stop();
    }

    /// A start was asked for that the drive does not yet know of.
    pub const fn is_start_pending(&self) -> bool {
        self.start.is_some()
    }

    /// One control tick; the master's frames go out when they are due.
    pub fn step(&mut self) {
        let now = self.bench.now_ns();
        if self.bench.status().state == State::Initialization {
            self.ready = now + 2 * 1000 * self.master.config().setpoint_period;
        }
        if now >= self.ready
            && let Some(rpm) = self.start.take()
        {
            self.master().start(rpm);
        }
        let now = now / 1000;
        if now >= self.silent_until {
            while let Some(frame) = self.poll_frame(now) {
                // Two frames every 50 ms, a request at a time and a window of blocks do not fill a queue of
                // 64.
                let _ = self.bench.send(frame);
            }
            // A job looks at what the drive says in every tick.
            self.silent_until = if self.master.is_at_work() { now } else { self.master.next_poll(now) };
        }
        self.bench.step();
        while let Some(received) = self.bench.receive() {
            self.master().handle_frame(&received.frame, received.time_ns / 1000);
        }
    }

    /// The next frame of the master's that is due at `now`, microseconds.
    fn poll_frame(&mut self, now: u64) -> Option<Frame> {
        let frame = self.master.poll_frame(now);
        #[cfg(feature = "update")]
        let frame = frame.or_else(|| self.master.poll_update_frame(now, &self.image));
        frame
    }

    /// Begins to program the drive: [`Master::update`], whose image has these bytes.
    ///
    /// # Errors
    /// An update whose end was not taken yet.
    #[cfg(feature = "update")]
    pub fn update(&mut self, image: Image, bytes: Vec<u8>) -> Result<(), NotTaken> {
        self.master().update(image)?;
        self.image = bytes;
        Ok(())
    }

    /// As many ticks as `seconds` have, to the nearest; none for a negative number.
    pub fn run(&mut self, seconds: f64) {
        let ticks = libm::round(seconds * f64::from(self.bench.node().board().tick_rate)) as u64;
        (0..ticks).for_each(|_| self.step());
    }

    /// The bench.
    pub const fn bench(&self) -> &Bench {
        &self.bench
    }

    /// The bench, to monitor its frames, inject faults and change the load.
    pub const fn bench_mut(&mut self) -> &mut Bench {
        &mut self.bench
    }

    /// The master: what the drive is asked for, and what it says.
    pub const fn master(&mut self) -> &mut Master {
        self.silent_until = 0;
        &mut self.master
    }

    /// The parameter set that the drive powered up with, and what limits it.
    pub const fn commissioning(&self) -> &Commissioning {
        &self.commissioning
    }
}
