//! Coefficients as constants of a C program.

use crate::bench::numbered;
use crate::error;
use narx_core::dictionary::{Parameters, engineering};
use narx_core::initialiser;
use narx_core::motor::{Board, Channel, Coefficients, Equipment, FrontEnd};
use pyo3::prelude::*;
use serde::Serialize;
use std::collections::HashMap;

/// Returns the coefficients that a drive with these `parameters` builds on a `board`, as a C99 header for
/// `narx_motor_init`: name or number -> value in its unit; the others have their factory values. `board` has
/// the fields of `narx_board_t`, and those that it leaves out are of the default board. `name` is that of the
/// constant.
///
/// Raises ParameterError for an unknown key, a value out of range, and parameters that do not fit each other.
#[pyfunction]
#[pyo3(signature = (parameters, board=None, name="coefficients"))]
pub(crate) fn coefficients(
    parameters: &Bound<'_, PyAny>,
    board: Option<&Bound<'_, PyAny>>,
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

/// Returns the default board with what `given` changes. Ranges are those of `Board::is_plausible`, and of C's
/// types.
fn described(given: &Bound<'_, PyAny>) -> PyResult<Board> {
    let mut board = Board::BENCH;
    for item in error::mapping("board", given)?.items()?.iter() {
        let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
        let key = key.to_string();
        match key.as_str() {
            "tick_rate" => board.tick_rate = whole(&key, &value, 1_000, 100_000)?,
            "earliest" => board.earliest = whole(&key, &value, 0, u16::MAX.into())?,
            "dead_time_ns" => board.dead_time_ns = whole(&key, &value, 0, u16::MAX.into())?,
            "bridge_milliohm" => board.bridge_milliohm = whole(&key, &value, 0, u16::MAX.into())?,
            "hall_capture" => board.hall_capture = flag(&key, &value)?,
            "comparator_capture" => board.comparator_capture = flag(&key, &value)?,
            "equipment" => {
                let bits = whole(&key, &value, 0, Equipment::all().bits().into())?;
                board.equipment = Equipment::from_bits_retain(bits);
            }
            "bus_voltage" => board.front_end.bus_voltage = channel(&key, &value)?,
            "phase_voltage" => board.front_end.phase_voltage = channel(&key, &value)?,
            "bus_current" => board.front_end.bus_current = channel(&key, &value)?,
            _ => return Err(error::parameter(format!("board: has no \"{key}\""))),
        }
    }
    Ok(board)
}

fn channel(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Channel> {
    let given: HashMap<String, Bound<'_, PyAny>> = value.extract().unwrap_or_default();
    let (Some(zero), Some(micro_per_code), 2) = (given.get("zero"), given.get("micro_per_code"), given.len())
    else {
        return Err(error::parameter(format!("board: {name} {value}: must have zero and micro_per_code")));
    };
    Ok(Channel {
        zero: whole(&format!("{name}.zero"), zero, 0, FrontEnd::CODE_MAX.into())?,
        micro_per_code: whole(
            &format!("{name}.micro_per_code"),
            micro_per_code,
            1,
            Channel::MICRO_PER_CODE_MAX.into(),
        )?,
    })
}

fn whole<T: TryFrom<i64>>(name: &str, value: &Bound<'_, PyAny>, min: i64, max: i64) -> PyResult<T> {
    let number = value.extract().ok().filter(|number| (min..=max).contains(number));
    number.and_then(|number| T::try_from(number).ok()).ok_or_else(|| {
        error::parameter(format!("board: {name} {value}: must be a whole number from {min} to {max}"))
    })
}

fn flag(name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    let error = |_| error::parameter(format!("board: {name} {value}: must be true or false"));
    value.extract().map_err(error)
}
