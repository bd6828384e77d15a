//! The ramp.

use super::{Column, numbers, raws, reals};
use crate::coefficients::constant;
use crate::error::{self, Given};
use narx_core::blocks::engineering::{raw, real};
use narx_core::blocks::{Ramp as Core, RampSettings};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

/// Rate limit of a set-point: y += clamp(target - y, -rate dt, rate dt).
///
/// Values are in units of your choice, from -32768 to 32768 in steps of 2^-16, with 16 fraction bits more
/// inside. It is the ramp of the drive's set-points (`narx_core::motor::ramp`), bit for bit.
///
/// rate: steepest change, units a second, more than 0. step_rate: steps a second, 1 to 1 000 000 Hz. value:
/// first value. Raises ParameterError, which names the argument that is out of range.
#[pyclass(module = "narx.blocks")]
pub(crate) struct Ramp {
    core: Core,
    step_rate: u32,
}

#[pymethods]
impl Ramp {
    #[new]
    #[pyo3(signature = (rate, step_rate, value=Given::Real(0.0)), text_signature = "(rate, step_rate, value=0.0)")]
    fn new(rate: Given, step_rate: Given, value: Given) -> PyResult<Self> {
        let [rate, value] = reals([("rate", rate), ("value", value)])?;
        let step_rate = error::whole("step_rate", step_rate, "Hz", 1, 1_000_000)?;
        numbers(|| {
            let mut core = Core::build(&RampSettings { rate: raw("rate", rate, "")?, step_rate })?;
            core.set(raw("value", value, "")?);
            Ok(Self { core, step_rate })
        })
    }

    /// Returns the coefficients as the definition of a C99 constant, for `narx_ramp_init_ready`.
    ///
    /// Raises ParameterError for a name that is none in C.
    #[pyo3(signature = (name="ramp"))]
    fn to_c(&self, name: &str) -> PyResult<String> {
        constant("narx_ramp_ready_t", name, self.core.ready())
    }

    /// Moves one step towards `target`; returns the new value.
    fn step(&mut self, target: Given) -> PyResult<f64> {
        let [target] = reals([("target", target)])?;
        numbers(|| Ok(real(self.core.step(raw("target", target, "")?))))
    }

    /// Moves a step towards each of a sequence of targets; returns the values: arrays of shape (n,).
    fn run<'py>(&mut self, py: Python<'py>, target: Column<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let targets = raws("target", &target)?;
        let core = &mut self.core;
        let values: Vec<f64> =
            py.detach(|| targets.into_iter().map(|target| real(core.step(target))).collect());
        Ok(values.into_pyarray(py))
    }

    /// Present value; it can be set.
    #[getter]
    fn value(&self) -> f64 {
        real(self.core.value())
    }

    #[setter]
    fn set_value(&mut self, value: Given) -> PyResult<()> {
        let [value] = reals([("value", value)])?;
        numbers(|| raw("value", value, "").map(|value| self.core.set(value)))
    }

    /// Steepest change in use, units a second: rounded to the fixed point of a step.
    #[getter]
    fn rate(&self) -> f64 {
        self.core.ready().rate as f64 / 4_294_967_296.0 * f64::from(self.step_rate)
    }
}
