//! The PI controller.

use super::{Column, numbers, raws, reals};
use crate::coefficients::constant;
use crate::error::{self, Given};
use narx_core::blocks::engineering::{gain, raw, real, value_of};
use narx_core::blocks::{Pi as Core, PiSettings};
use narx_core::motor::gain::Gain;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

/// Proportional-integral controller: u = Kp e + integral of Ki e dt, within its limits.
///
/// Errors and outputs are in units of your choice, from -32768 to 32768 in steps of 2^-16. The integrator has
/// 16 fraction bits more and never holds more than brings the output to a limit. It is the controller of the
/// drive's loops (`narx_core::motor::control::pi`), bit for bit.
///
/// proportional: Kp, output per error, 0 or more. integral: Ki, output per error and second, 0 or more.
/// step_rate: steps a second, 1 to 1 000 000 Hz. minimum, maximum: limits of the output. Raises
/// ParameterError, which names the argument that is out of range.
#[pyclass(module = "narx.blocks")]
pub(crate) struct Pi {
    core: Core,
    proportional: Gain,
    step_rate: u32,
}

#[pymethods]
impl Pi {
    #[new]
    #[pyo3(signature = (proportional, integral, step_rate, minimum, maximum))]
    fn new(
        proportional: Given,
        integral: Given,
        step_rate: Given,
        minimum: Given,
        maximum: Given,
    ) -> PyResult<Self> {
        let [proportional, integral, minimum, maximum] = reals([
            ("proportional", proportional),
            ("integral", integral),
            ("minimum", minimum),
            ("maximum", maximum),
        ])?;
        let step_rate = error::whole("step_rate", step_rate, "Hz", 1, 1_000_000)?;
        numbers(|| {
            let proportional = gain("proportional", proportional)?;
            let core = Core::build(&PiSettings {
                proportional,
                integral: gain("integral", integral)?,
                step_rate,
                minimum: raw("minimum", minimum, "")?,
                maximum: raw("maximum", maximum, "")?,
            })?;
            Ok(Self { core, proportional, step_rate })
        })
    }

    /// Returns the coefficients as the definition of a C99 constant, for `narx_pi_init_ready`.
    ///
    /// Raises ParameterError for a name that is none in C.
    #[pyo3(signature = (name="pi"))]
    fn to_c(&self, name: &str) -> PyResult<String> {
        constant("narx_pi_ready_t", name, self.core.ready())
    }

    /// Returns the output for one `error`.
    fn step(&mut self, error: Given) -> PyResult<f64> {
        let [error] = reals([("error", error)])?;
        numbers(|| Ok(real(self.core.step(raw("error", error, "")?))))
    }

    /// Returns the outputs for a sequence of errors: arrays of shape (n,).
    fn run<'py>(&mut self, py: Python<'py>, error: Column<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let errors = raws("error", &error)?;
        let core = &mut self.core;
        let outputs: Vec<f64> =
            py.detach(|| errors.into_iter().map(|error| real(core.step(error))).collect());
        Ok(outputs.into_pyarray(py))
    }

    /// Follows the output `applied` that something else decided in a step whose error was `error`. The
    /// integrator goes an eighth of the way to the value that would have given `applied` (back-calculation),
    /// so that the controller takes over again without a bump.
    #[pyo3(signature = (applied, error))]
    fn track(&mut self, applied: Given, error: Given) -> PyResult<()> {
        let [applied, error] = reals([("applied", applied), ("error", error)])?;
        let (applied, error) = numbers(|| Ok((raw("applied", applied, "")?, raw("error", error, "")?)))?;
        self.core.track(applied, error);
        Ok(())
    }

    /// Sets the integrator so that it alone gives `output`.
    fn hold(&mut self, output: Given) -> PyResult<()> {
        let [output] = reals([("output", output)])?;
        numbers(|| raw("output", output, "").map(|output| self.core.hold(output)))
    }

    /// Kp in use, output per error: rounded to 30 bits.
    #[getter]
    fn proportional(&self) -> f64 {
        value_of(self.proportional)
    }

    /// Ki in use, output per error and second: Ki x step time is rounded to 30 bits.
    #[getter]
    fn integral(&self) -> f64 {
        value_of(self.core.ready().gains.integral) * f64::from(self.step_rate)
    }
}
