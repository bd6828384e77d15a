//! Coefficients as constants of a C program.

use crate::bench::numbered;
use crate::error;
use narx_core::dictionary::{Parameters, engineering};
use narx_core::initialiser;
use narx_core::motor::{Board, Channel, Coefficients, Equipment};
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyString};
use serde::Serialize;

/// Returns the coefficients that a drive with these `parameters` builds on a `board`, as a C99 header for
/// `narx_motor_init`: name or number -> value in its unit; the others have their factory values. `board` has
/// the fields of `narx_board_t`, and those that it leaves out are of the default board. `name` is that of the
/// constant.
///
/// Raises ParameterError for an unknown key, a value out of range, and parameters that do not fit each other.
#[pyfunction]
#[pyo3(signature = (parameters, board=None, name="coefficients"))]
pub(crate) fn coefficients(
    parameters: &Bound<'_, PyMapping>,
    board: Option<&Bound<'_, PyMapping>>,
    name: &str,
) -> PyResult<String> {
    let board = board.map_or(Ok(Board::BENCH), described)?;
    let mut set = Parameters::new();
    for (number, value) in numbered(parameters)? {
        engineering::enter(&mut set, number, value).map_err(error::parameter)?;
    }
    let built = Coefficients::build(&set, &board).map_err(error::parameter)?;
    let mut text = String::new();
    initialiser::header(&mut text, checked(name)?, &built).map_err(error::parameter)?;
    Ok(text)
}

/// Returns the definition of a constant.
pub(crate) fn constant(c_type: &str, name: &str, value: &impl Serialize) -> PyResult<String> {
    let mut text = String::new();
    initialiser::define(&mut text, c_type, checked(name)?, value).map_err(error::parameter)?;
    Ok(text)
}

/// Returns a name that C takes.
fn checked(name: &str) -> PyResult<&str> {
    let error = || error::parameter(format!("name \"{name}\": is not a name in C"));
    initialiser::is_identifier(name).then_some(name).ok_or_else(error)
}

/// Returns the default board with what `given` changes.
fn described(given: &Bound<'_, PyMapping>) -> PyResult<Board> {
    let mut board = Board::BENCH;
    for item in given.items()?.iter() {
        let (key, value): (String, Bound<'_, PyAny>) = item.extract()?;
        match key.as_str() {
            "tick_rate" => board.tick_rate = field(&key, &value)?,
            "earliest" => board.earliest = field(&key, &value)?,
            "dead_time_ns" => board.dead_time_ns = field(&key, &value)?,
            "bridge_milliohm" => board.bridge_milliohm = field(&key, &value)?,
            "hall_capture" => board.hall_capture = field(&key, &value)?,
            "comparator_capture" => board.comparator_capture = field(&key, &value)?,
            "equipment" => board.equipment = Equipment::from_bits_truncate(field(&key, &value)?),
            "bus_voltage" => board.front_end.bus_voltage = channel(&key, &value)?,
            "phase_voltage" => board.front_end.phase_voltage = channel(&key, &value)?,
            "bus_current" => board.front_end.bus_current = channel(&key, &value)?,
            _ => return Err(error::parameter(format!("board: has no \"{key}\""))),
        }
    }
    if board.is_plausible() {
        Ok(board)
    } else {
        Err(error::parameter(format!(
            "board: no controller fits it: tick_rate must be from 1000 to 100000 Hz, micro_per_code from 1 to {}, \
             and zero a code of the converter",
            Channel::MICRO_PER_CODE_MAX
        )))
    }
}

fn channel(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Channel> {
    let part = |key: &str| {
        value
            .get_item(PyString::new(value.py(), key))
            .map_err(|_| error::parameter(format!("board: {name} must have zero and micro_per_code")))
    };
    Ok(Channel { zero: field(name, &part("zero")?)?, micro_per_code: field(name, &part("micro_per_code")?)? })
}

fn field<'py, T: FromPyObjectOwned<'py>>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<T> {
    value.extract().map_err(|_| error::parameter(format!("board: {name} {value} does not fit")))
}
