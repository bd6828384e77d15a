//! The identification of a motor.

use crate::error::{self, Given};
use crate::master::Master;
use narx_core::identification::{Asked, Figure, Halls, Identification as Core, IdentificationError, Turned};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Mutex, PoisonError};

/// The identification of a motor, step by step: `narx.Drive.identify`.
#[pyclass(module = "narx._core", frozen)]
pub(crate) struct Identification(Mutex<Core>);

#[pymethods]
impl Identification {
    /// pole_pairs: `None` if they are counted. current: largest phase current, A, `None` for a heat of 6 W.
    /// bridge: resistance of two switches, ohm, `None` for that of narx's own board. turn: the rotor may
    /// turn. halls: the hall sensors are calibrated.
    #[new]
    #[pyo3(signature = (pole_pairs, current, bridge, turn, halls))]
    fn new(
        pole_pairs: Option<Given>,
        current: Option<Given>,
        bridge: Option<Given>,
        turn: bool,
        halls: bool,
    ) -> PyResult<Self> {
        let pole_pairs = pole_pairs.map(|value| error::whole("pole_pairs", value, "", 1, 50)).transpose()?;
        let mut asked = Asked { turn, halls, ..Asked::new(pole_pairs) };
        if let Some(current) = current {
            asked.current = Some(error::magnitude("current", current, "A")?);
        }
        if let Some(bridge) = bridge {
            asked.bridge = error::magnitude("bridge", bridge, "ohm")?;
        }
        Core::new(asked).map(|core| Self(Mutex::new(core))).map_err(error::parameter)
    }

    /// Part that is under way: "asking", "holding", "counting", "spinning", "accelerating", "calibrating" or
    /// "restoring".
    #[getter]
    fn stage(&self) -> &'static str {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).stage().name()
    }

    /// `step` has returned the figures, or raised the error.
    #[getter]
    fn has_ended(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).has_ended()
    }

    /// Goes on; returns the figures once it has ended: name -> value, or value and uncertainty. Raises the
    /// error with which it has ended.
    fn step<'py>(&self, py: Python<'py>, master: &Master) -> PyResult<Option<Bound<'py, PyDict>>> {
        let outcome = master
            .with(py, |master, now| self.0.lock().unwrap_or_else(PoisonError::into_inner).step(master, now));
        let Some(outcome) = outcome else { return Ok(None) };
        let found = outcome.map_err(|error| match error {
            IdentificationError::Job(error) => master.job_error(error),
            IdentificationError::Request(..)
            | IdentificationError::Download(_)
            | IdentificationError::Lost => error::no_answer(error),
            IdentificationError::NotTaken(_) | IdentificationError::Aborted => error::refused(error),
            error => error::start(error),
        })?;
        let figures = PyDict::new(py);
        let pair = |Figure { value, uncertainty }| (value, uncertainty);
        figures.set_item("pole_pairs", found.pole_pairs)?;
        figures.set_item("temperature", found.temperature)?;
        figures.set_item("supply_voltage", found.supply)?;
        figures.set_item("current", found.current)?;
        figures.set_item("resistance", pair(found.resistance))?;
        figures.set_item("inductance", pair(found.inductance))?;
        if let Some(turned) = found.turned {
            let Turned { torque_constant, inertia, friction, static_friction, viscous_friction, speed } =
                turned;
            figures.set_item("torque_constant", pair(torque_constant))?;
            figures.set_item("inertia", pair(inertia))?;
            figures.set_item("friction", pair(friction))?;
            figures.set_item("static_friction", static_friction)?;
            figures.set_item("viscous_friction", viscous_friction)?;
            figures.set_item("speed", speed)?;
        }
        if let Some(Halls { order, polarity, offset }) = found.halls {
            figures.set_item("halls", (order, polarity, offset))?;
        }
        Ok(Some(figures))
    }

    /// A mark on the shaft passes the same place as the last time. False if turns are not counted now.
    fn mark(&self, py: Python<'_>, master: &Master) -> bool {
        master.with(py, |_, now| self.0.lock().unwrap_or_else(PoisonError::into_inner).mark(now))
    }

    /// Ends it: the motor stops, and the parameters get their values back in the steps that follow.
    fn abort(&self, py: Python<'_>, master: &Master) {
        master.with(py, |master, _| {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).abort(master);
        });
    }
}
