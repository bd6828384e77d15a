//! The drive, as its master sees it.

use crate::error;
use crate::session::Shared;
use crate::state;
use narx_core::dictionary::number;
use narx_core::motor::commutation::Direction;
use narx_core::motor::event::{Refusal, Status};
use narx_core::motor::{Cause, State};
use narx_sim::session::Session;
use pyo3::prelude::*;
use std::collections::HashSet;

/// A drive. What is asked of it is sent at once and repeated as simulated time runs.
#[pyclass(module = "narx", frozen)]
pub(crate) struct Drive(Shared);

/// What a MOTOR_CMD can carry: whole rpm of 16 bits.
const RPM_MAX: f64 = u16::MAX as f64;
/// Longest wait for a start, ns.
const START_MAX: u64 = 10_000_000_000;
/// A request is on the bus and its answer back within this time, ns.
const ANSWER: u64 = 10_000_000;

impl Drive {
    pub(crate) const fn new(session: Shared) -> Self {
        Self(session)
    }
}

#[pymethods]
impl Drive {
    /// Asks for a speed, mechanical rpm, negative in reverse. With `wait`, time runs until the motor is in open or closed
    /// loop (state 3, 4 or 5, as the mode has it), or an error says why it is not.
    #[pyo3(signature = (rpm, wait=true))]
    fn start(&self, py: Python<'_>, rpm: f64, wait: bool) -> PyResult<()> {
        let rpm = error::whole("rpm", rpm, "", -RPM_MAX, RPM_MAX)?;
        let ticks = self.0.with(py, |session| {
            session.start(rpm as i32);
            START_MAX / session.bench().period_ns()
        });
        if !wait {
            return Ok(());
        }
        let mut start = Start { reverse: rpm < 0, asked: None, outcome: Ok(()) };
        if self.0.run_until(py, ticks, |session| start.is_over(session))? {
            return start.outcome.map_err(error::start);
        }
        let state = self.0.with(py, |session| session.bench().status().state);
        Err(error::start(format!(
            "no start within {} s: the drive is in {}",
            START_MAX / 1_000_000_000,
            state.name()
        )))
    }

    /// Asks for another speed in the same direction, mechanical rpm.
    fn set_speed(&self, py: Python<'_>, rpm: f64) -> PyResult<()> {
        let rpm = error::whole("rpm", rpm, "", 0.0, RPM_MAX)?;
        self.0.with(py, |session| session.set_speed(rpm as u16));
        Ok(())
    }

    /// Asks for Standby.
    fn stop(&self, py: Python<'_>) {
        self.0.with(py, Session::stop);
    }

    /// The drive's state.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        state::member(py, self.0.with(py, |session| session.bench().status().state))
    }

    /// Names of the bits of the fault word that are set.
    #[getter]
    fn faults(&self, py: Python<'_>) -> HashSet<String> {
        self.0.with(py, |session| faults(session.bench().status()).collect())
    }
}

/// A start that is waited for.
struct Start {
    reverse: bool,
    /// When the request was sent, ns.
    asked: Option<u64>,
    /// Why there is none, in the end.
    outcome: Result<(), String>,
}

impl Start {
    fn is_over(&mut self, session: &mut Session) -> bool {
        if session.is_start_pending() {
            return false;
        }
        let now = session.bench().now_ns();
        if now < *self.asked.get_or_insert(now) + ANSWER {
            return false;
        }
        let status = session.bench().status();
        let enabled = |number| session.bench().node().parameters().raw(number) != 0;
        let turns = (status.direction == Direction::Reverse) == self.reverse;
        match status.state {
            State::HallClosedLoop | State::SensorlessClosedLoop => turns,
            // The other modes only pass through it.
            State::OpenLoop => turns && !enabled(number::SENSORLESS_ENABLE) && !enabled(number::HALL_ENABLE),
            State::Fault => {
                self.outcome = Err(fault(status));
                true
            }
            _ if status.refusal != Refusal::None => {
                self.outcome = Err(refusal(session, status.refusal));
                true
            }
            _ => false,
        }
    }
}

fn faults(status: &Status) -> impl Iterator<Item = String> + '_ {
    status.faults.iter_names().map(|(name, _)| name.to_ascii_lowercase())
}

fn fault(status: &Status) -> String {
    let names: Vec<String> = faults(status).collect();
    let cause = Cause::TABLE.iter().find(|row| row.cause as u16 == status.extended_code);
    let meaning = cause.map_or("no cause is latched", |row| row.meaning);
    format!("the drive is in Fault: {meaning} ({})", names.join(", "))
}

/// Which parameter does not fit is known for one of the refusals.
fn refusal(session: &Session, refusal: Refusal) -> String {
    let reason = state::words(&refusal).replace('_', " ");
    let rejected = session.bench().node().read_parameter(number::REJECTED_PARAMETER);
    let row = rejected
        .and_then(|number| u16::try_from(number).ok())
        .and_then(narx_core::dictionary::Dictionary::row);
    match row.filter(|_| refusal == Refusal::Parameters) {
        Some(row) => format!(
            "the drive refused the start: parameter {} \"{}\" does not fit the others",
            row.number, row.name
        ),
        None => format!("the drive refused the start: {reason}"),
    }
}
