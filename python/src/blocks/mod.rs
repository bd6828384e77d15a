//! The blocks of core. Floats and arrays are converted to fixed point here, and the rounded values can be
//! read back.

mod commutation;
mod hall;
mod pi;
mod ramp;
mod zero_crossing;

pub(crate) use commutation::Commutation;
pub(crate) use hall::{Hall, HallReading};
pub(crate) use pi::Pi;
pub(crate) use ramp::Ramp;
pub(crate) use zero_crossing::{ZeroCrossing, ZeroCrossingReading};

use crate::error::{self, Given};
use narx_core::blocks::engineering::{NumberError, raw};
use narx_core::motor::{Direction, Step};
use numpy::{AllowTypeChange, PyArrayLike1};
use pyo3::prelude::*;

/// A column of numbers, or anything that numpy converts to one.
pub(crate) type Column<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;

/// Converts a column to raw I16F16, rounded to nearest.
fn raws(name: &str, values: &Column<'_>) -> PyResult<Vec<i32>> {
    let values = values.as_array();
    let row =
        |(row, value): (usize, &f64)| raw(&format!("{name}[{row}]"), *value, "").map_err(error::parameter);
    values.iter().enumerate().map(row).collect()
}

/// Converts scalars to finite numbers; each is given with its name.
fn reals<const N: usize>(given: [(&str, Given); N]) -> PyResult<[f64; N]> {
    let mut reals = [0.0; N];
    for (real, (name, given)) in reals.iter_mut().zip(given) {
        *real = error::finite(name, given, "")?;
    }
    Ok(reals)
}

/// Runs what takes numbers; one that is out of range becomes a ParameterError, which names it.
fn numbers<'a, T>(run: impl FnOnce() -> Result<T, NumberError<'a>>) -> PyResult<T> {
    run().map_err(error::parameter)
}

const fn direction(reverse: bool) -> Direction {
    if reverse { Direction::Reverse } else { Direction::Forward }
}

/// Returns the step with this number.
fn step(number: impl Into<Given>) -> PyResult<Step> {
    let number: u8 = error::whole("step", number, "", 0, Step::ALL.len() as u8 - 1)?;
    Ok(Step::ALL[usize::from(number)])
}

/// Builds `narx.blocks.Step`: an `IntEnum` with core's numbers.
pub(crate) fn steps(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let members = Step::ALL.map(|step| (format!("{step:?}"), step as u8));
    let doc = "Switch patterns: the first letter's phase is switched, the second's held low, the third floats; COAST is all off, LOCKs hold the rotor.";
    crate::state::enumeration(py, "narx.blocks", "Step", doc, &members)
}

/// Returns the member of `narx.blocks.Step` for a step.
fn member(py: Python<'_>, step: Step) -> PyResult<Bound<'_, PyAny>> {
    py.import("narx._core")?.getattr("Step")?.call1((step as u8,))
}

/// Checks that two columns have the same length.
fn same_length(name: &str, length: usize, other: &str, wanted: usize) -> PyResult<()> {
    if length == wanted {
        return Ok(());
    }
    Err(error::parameter(format!("{name} of {length} rows: must have {wanted}, as {other} has")))
}
