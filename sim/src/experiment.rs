//! A start and what a test engineer reads off it: the same short run for many motors, loads, parameters and
//! faults.

use crate::plant::{Injection, Observation};
use crate::session::{Session, SessionConfig, SessionError};
use alloc::format;
use alloc::string::String;
use core::f64::consts::TAU;
use narx_core::commissioning::Mode;
use narx_core::motor::guard::fault::{Cause, FaultWord};
use narx_core::motor::{State, Status};

/// Configuration of a run.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// The bench.
    pub session: SessionConfig,
    /// Set-point, mechanical rpm, negative in reverse; without one the middle of what commissioning allows.
    pub rpm: Option<i32>,
    /// From the Drive request to the end, s.
    pub seconds: f64,
    /// Injected fault, and its time after the Drive request, s.
    pub fault: Option<(Injection, f64)>,
}

/// Outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// In the state that the mode leads to.
    Running,
    /// In Fault.
    Fault,
    /// The drive refused the start, or gave up.
    Standby,
    /// Still on its way, or on its way again.
    Starting,
}

impl Outcome {
    /// One word for tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Running => "running",
            Self::Fault => "fault",
            Self::Standby => "standby",
            Self::Starting => "starting",
        }
    }
}

/// Results of a run. Times count from the Drive request, means are those of the last quarter; NaN stands for
/// what was never reached.
#[derive(Clone, Debug)]
pub struct Figures {
    /// Outcome of the run.
    pub outcome: Outcome,
    /// State at the end.
    pub state: State,
    /// Set-point, rpm.
    pub setpoint: i32,
    /// To the state that the mode leads to, s.
    pub start_time: f64,
    /// Starts and restarts.
    pub attempts: u32,
    /// To 90 % of the set-point, s.
    pub time_to_speed: f64,
    /// Highest speed beyond the set-point, share of it.
    pub overshoot: f64,
    /// Mean true speed, rpm.
    pub speed: f64,
    /// Mean less set-point, share of it.
    pub speed_error: f64,
    /// Highest less lowest speed in the last quarter, share of the set-point.
    pub ripple: f64,
    /// Largest magnitude of a phase current, A.
    pub peak_current: f64,
    /// Mean power from the supply, W.
    pub power: f64,
    /// Lowest bus voltage, V.
    pub bus_voltage_min: f64,
    /// Highest bus voltage, V.
    pub bus_voltage_max: f64,
    /// Winding temperature at the end, degrees Celsius.
    pub winding_temperature: f64,
    /// Faults at the end.
    pub faults: FaultWord,
    /// Extended code of the first critical one, 0 without.
    pub extended_code: u16,
    /// Of all that the drive answered since it booted.
    pub digest: u64,
}

/// A figure for tables.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number.
    Count(i64),
    /// Any number.
    Number(f64),
    /// A word.
    Text(String),
}

/// Name and unit of every figure, in the order of [`Figures::values`].
pub const FIGURES: [(&str, &str); 19] = [
    ("outcome", ""),
    ("state", ""),
    ("setpoint", "rpm"),
    ("start_time", "s"),
    ("attempts", ""),
    ("time_to_speed", "s"),
    ("overshoot", ""),
    ("speed", "rpm"),
    ("speed_error", ""),
    ("ripple", ""),
    ("peak_current", "A"),
    ("power", "W"),
    ("bus_voltage_min", "V"),
    ("bus_voltage_max", "V"),
    ("winding_temperature", "degC"),
    ("faults", ""),
    ("extended_code", ""),
    ("cause", ""),
    ("digest", ""),
];

impl Figures {
    /// The values of [`FIGURES`].
    pub fn values(&self) -> [Value; FIGURES.len()] {
        use Value::{Count, Number, Text};
        let names = self.faults.iter_names().map(|(name, _)| name.to_ascii_lowercase());
        let faults = names.reduce(|all, name| format!("{all}, {name}")).unwrap_or_default();
        let cause = Cause::TABLE.iter().find(|row| row.cause as u16 == self.extended_code);
        [
            Text(self.outcome.name().into()),
            Count((self.state as u8).into()),
            Count(self.setpoint.into()),
            Number(self.start_time),
            Count(self.attempts.into()),
            Number(self.time_to_speed),
            Number(self.overshoot),
            Number(self.speed),
            Number(self.speed_error),
            Number(self.ripple),
            Number(self.peak_current),
            Number(self.power),
            Number(self.bus_voltage_min),
            Number(self.bus_voltage_max),
            Number(self.winding_temperature),
            Text(faults),
            Count(self.extended_code.into()),
            Text(cause.map_or("", |row| row.meaning).into()),
            // Wider than the numbers of many tables.
            Text(format!("{:016x}", self.digest)),
        ]
    }
}

/// Ticks between two looks at whether to go on: some 10 ms of work.
const CHUNK: u64 = 1000;

impl Experiment {
    /// Runs it, as long as `goes_on` says so; `None` if it did not. The session is what the run leaves
    /// behind.
    ///
    /// # Errors
    /// As [`SessionConfig::commission`].
    pub fn run(&self, mut goes_on: impl FnMut() -> bool) -> Result<Option<(Figures, Session)>, SessionError> {
        let mut session = Session::new(&self.session)?;
        let range = session.commissioning();
        let target = self.rpm.unwrap_or((0.5 * (range.speed_min + range.speed_max)) as i32);
        session.start(target);
        // Self-tests take half a second.
        while session.is_start_pending() {
            session.step();
        }
        let tick_rate = f64::from(self.session.board.tick_rate);
        let ticks_of = |seconds: f64| libm::round(seconds * tick_rate) as u64;
        let ticks = ticks_of(self.seconds);
        let breaks = self.fault.map(|(injection, time)| (injection, ticks_of(time)));
        let mut watch = Watch::new(&session, self.session.mode, target);
        for tick in 0..ticks {
            if tick % CHUNK == 0 && !goes_on() {
                return Ok(None);
            }
            if let Some((injection, _)) = breaks.filter(|(_, when)| *when == tick) {
                session.bench_mut().plant_mut().inject(injection);
            }
            session.step();
            watch.look(&session, tick >= ticks - ticks / 4);
        }
        Ok(Some((watch.figures(&session), session)))
    }
}

/// Values kept from the ticks of a run.
struct Watch {
    target: f64,
    /// Driving state to which the mode leads.
    running: State,
    begun: f64,
    before: State,
    start_time: f64,
    time_to_speed: f64,
    attempts: u32,
    /// In the set-point's direction, rpm.
    highest: f64,
    peak_current: f64,
    bus_voltage: (f64, f64),
    /// Speed over the last quarter, rpm.
    speed: (f64, f64),
    /// Observation at the beginning of the last quarter.
    quarter: Option<Observation>,
}

/// Nothing seen yet.
const NOTHING: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

fn widen((low, high): (f64, f64), value: f64) -> (f64, f64) {
    (low.min(value), high.max(value))
}

impl Watch {
    fn new(session: &Session, mode: Mode, target: i32) -> Self {
        let running = match mode {
            Mode::Hall => State::HallClosedLoop,
            Mode::Sensorless => State::SensorlessClosedLoop,
            Mode::OpenLoop => State::OpenLoop,
        };
        Self {
            target: target.into(),
            running,
            begun: session.bench().time(),
            before: session.bench().status().state,
            start_time: f64::NAN,
            time_to_speed: f64::NAN,
            attempts: 0,
            highest: 0.0,
            peak_current: 0.0,
            bus_voltage: NOTHING,
            speed: NOTHING,
            quarter: None,
        }
    }

    fn look(&mut self, session: &Session, in_last_quarter: bool) {
        let (seen, state) = (session.bench().plant().observe(), session.bench().status().state);
        let time = seen.time - self.begun;
        let rpm = seen.speed * 60.0 / TAU;
        let along = rpm * if self.target < 0.0 { -1.0 } else { 1.0 };
        if state != self.before {
            let leaves = self.before == State::Standby && state.is_driving();
            self.attempts += u32::from(leaves || state == State::SensorlessAutoRestart);
            self.before = state;
        }
        if state == self.running && self.start_time.is_nan() {
            self.start_time = time;
        }
        if along >= 0.9 * self.target.abs() && self.time_to_speed.is_nan() {
            self.time_to_speed = time;
        }
        self.highest = self.highest.max(along);
        self.peak_current = self.peak_current.max(seen.peak_current);
        self.bus_voltage = widen(self.bus_voltage, seen.bus_voltage);
        if in_last_quarter {
            self.speed = widen(self.speed, rpm);
            self.quarter.get_or_insert(seen);
        }
    }

    fn figures(&self, session: &Session) -> Figures {
        let (bench, size) = (session.bench(), self.target.abs());
        let &Status { state, faults, extended_code, .. } = bench.status();
        let now = bench.plant().observe();
        let rate = |of: fn(&Observation) -> f64| {
            self.quarter.as_ref().map_or(f64::NAN, |then| (of(&now) - of(then)) / (now.time - then.time))
        };
        let speed = rate(|seen| seen.angle) * 60.0 / TAU;
        Figures {
            outcome: match state {
                State::Fault => Outcome::Fault,
                State::Standby => Outcome::Standby,
                state if state == self.running => Outcome::Running,
                _ => Outcome::Starting,
            },
            state,
            setpoint: self.target as i32,
            start_time: self.start_time,
            attempts: self.attempts,
            time_to_speed: self.time_to_speed,
            overshoot: (self.highest / size - 1.0).max(0.0),
            speed,
            speed_error: speed / self.target - 1.0,
            ripple: (self.speed.1 - self.speed.0) / size,
            peak_current: self.peak_current,
            power: rate(|seen| seen.ledger.source - seen.ledger.source_loss),
            bus_voltage_min: self.bus_voltage.0,
            bus_voltage_max: self.bus_voltage.1,
            winding_temperature: now.winding_temperature,
            faults,
            extended_code,
            digest: bench.digest(),
        }
    }
}
