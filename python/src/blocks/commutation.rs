//! Six-step commutation.

use super::{Column, direction, member, numbers, reals, same_length, step};
use crate::coefficients::constant;
use crate::error::{self, Given};
use crate::state::words;
use narx_core::blocks::engineering::{ADVANCE, instant, position};
use narx_core::blocks::{Commutation as Core, CommutationSettings};
use narx_core::motor::Step;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

/// A step and the changes within its period: instants in periods, 0 to 1.
type Answer<'py> = (Bound<'py, PyAny>, Vec<(f64, Bound<'py, PyAny>)>);

/// Six-step commutation: the step of each period, and the changes within it, from the rotor's angle and
/// speed.
///
/// Sector s spans 30 + 60 s to 90 + 60 s electrical degrees, where 0 is the rising zero crossing of phase A's
/// back-EMF. Forward torque takes the step of the rotor's sector (`for_sector`), reverse torque the opposite
/// one. It is the drive's commutator (`narx_core::motor::commutate::commutator`), bit for bit.
///
/// tick_rate: periods a second, 1 to 1 000 000 Hz. advance: timing advance, 0 to 30 electrical degrees
/// (parameter 273). earliest: first instant of a period at which a new step can act, 0 to 1 period. Raises
/// ParameterError, which names the argument that is out of range.
#[pyclass(module = "narx.blocks")]
pub(crate) struct Commutation {
    core: Core,
    tick_rate: u32,
}

#[pymethods]
impl Commutation {
    #[new]
    #[pyo3(signature = (tick_rate=Given::Whole(10_000), advance=Given::Real(0.0), earliest=Given::Real(0.125)),
           text_signature = "(tick_rate=10000, advance=0.0, earliest=0.125)")]
    fn new(tick_rate: Given, advance: Given, earliest: Given) -> PyResult<Self> {
        let tick_rate = error::whole("tick_rate", tick_rate, "Hz", 1, 1_000_000)?;
        let [advance, earliest] = reals([("advance", advance), ("earliest", earliest)])?;
        let core = numbers(|| {
            let advance_cdeg = ADVANCE.setting("advance", advance)?;
            let earliest = instant("earliest", earliest)?;
            Ok(Core::build(&CommutationSettings { advance_cdeg, earliest })?)
        })?;
        Ok(Self { core, tick_rate })
    }

    /// Returns the coefficients as the definition of a C99 constant, for `narx_commutation_init_ready`.
    ///
    /// Raises ParameterError for a name that is none in C.
    #[pyo3(signature = (name="commutation"))]
    fn to_c(&self, name: &str) -> PyResult<String> {
        constant("narx_commutator_coefficients_t", name, self.core.ready())
    }

    /// Returns the step at the earliest instant of a period, and up to two changes later in it as (instant in
    /// periods, step). angle: electrical degrees at the period's boundary. speed: electrical rev/s, negative
    /// in reverse. reverse: torque in reverse.
    #[pyo3(signature = (angle, speed, reverse=false))]
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        angle: Given,
        speed: Given,
        reverse: bool,
    ) -> PyResult<Answer<'py>> {
        let [angle, speed] = reals([("angle", angle), ("speed", speed)])?;
        let position = position(angle, speed, self.tick_rate).map_err(error::parameter)?;
        let (step, changes) = self.core.step(position, direction(reverse));
        let change = |instant: u16, step| Ok((f64::from(instant) / 65_536.0, member(py, step)?));
        let changes: PyResult<_> = changes.iter().map(|c| change(c.instant, c.step)).collect();
        Ok((member(py, step)?, changes?))
    }

    /// Returns the step in force at the end of each period, as numbers of `Step`. angle, speed: arrays of
    /// shape (n,), as for `step`.
    #[pyo3(signature = (angle, speed, reverse=false))]
    fn run<'py>(
        &mut self,
        py: Python<'py>,
        angle: Column<'py>,
        speed: Column<'py>,
        reverse: bool,
    ) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let (angle, speed) = (angle.as_array(), speed.as_array());
        same_length("speed", speed.len(), "angle", angle.len())?;
        let mut steps = Vec::with_capacity(angle.len());
        for (angle, speed) in angle.iter().zip(&speed) {
            let position = position(*angle, *speed, self.tick_rate).map_err(error::parameter)?;
            let (step, changes) = self.core.step(position, direction(reverse));
            steps.push(changes.last().map_or(step, |last| last.step) as u8);
        }
        Ok(steps.into_pyarray(py))
    }

    /// Forgets the sector; call it after the bridge was off.
    fn reset(&mut self) {
        self.core.reset();
    }

    /// Returns the step that gives torque to a rotor in `sector`, 0 to 5.
    #[staticmethod]
    #[pyo3(signature = (sector, reverse=false))]
    fn for_sector(py: Python<'_>, sector: Given, reverse: bool) -> PyResult<Bound<'_, PyAny>> {
        let sector = error::whole("sector", sector, "", 0, 5)?;
        member(py, Step::for_sector(sector, direction(reverse)))
    }

    /// Returns the actions of a step on the legs A, B and C: "floating", "low" or "switched".
    #[staticmethod]
    fn legs(step: Given) -> PyResult<(String, String, String)> {
        let [a, b, c] = self::step(step)?.legs().map(|leg| words(&leg));
        Ok((a, b, c))
    }
}
