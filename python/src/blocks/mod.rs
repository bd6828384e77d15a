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

use crate::error;
use narx_core::blocks::Position;
use narx_core::motor::gain::Gain;
use narx_core::motor::{Direction, Step};
use numpy::{AllowTypeChange, PyArrayLike1};
use pyo3::prelude::*;

/// A column of numbers, or anything that numpy converts to one.
pub(crate) type Column<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;

const ONE: f64 = 65_536.0;
const TURN: f64 = 4_294_967_296.0;

/// Converts a value to raw I16F16, rounded to nearest.
fn raw(name: &str, value: f64, unit: &str) -> PyResult<i32> {
    let allowed = "a finite number from -32768 to 32767.99998";
    let fits = |value: f64| (-32_768.0..32_767.999_99).contains(&value);
    error::number(name, value, unit, allowed, fits).map(|value| (value * ONE).round() as i32)
}

/// Converts a column to raw I16F16, rounded to nearest.
fn raws(name: &str, values: &Column<'_>) -> PyResult<Vec<i32>> {
    let values = values.as_array();
    values.iter().enumerate().map(|(row, value)| raw(&format!("{name}[{row}]"), *value, "")).collect()
}

fn real(raw: i32) -> f64 {
    f64::from(raw) / ONE
}

/// Returns the nearest gain of 30 bits.
fn gain(name: &str, value: f64) -> PyResult<Gain> {
    let mut shift = 62;
    let least = 2.0_f64.powi(-55);
    let largest = f64::from(Gain::MANTISSA_MAX);
    let allowed = format!("0, or from {least:e} to {largest:e}");
    error::number(name, value, "", &allowed, |value| value == 0.0 || (least..=largest).contains(&value))?;
    let scaled = |shift: i32| (value * 2.0_f64.powi(shift)).round();
    while shift > 0 && scaled(shift) > largest {
        shift -= 1;
    }
    Gain::new(scaled(shift) as i32, shift as u8).ok_or_else(|| error::parameter(format!("{name} {value}")))
}

fn value_of(gain: Gain) -> f64 {
    f64::from(gain.mantissa()) * 2.0_f64.powi(-i32::from(gain.shift()))
}

/// Converts a value in an SI unit to a whole number of the unit of core's setting.
fn scaled<T: TryFrom<i64>>(name: &str, value: f64, unit: &str, per_unit: f64) -> PyResult<T> {
    let given = error::finite(name, value, unit)?;
    let refused = || error::parameter(format!("{name} {value} {unit}: out of range"));
    T::try_from((given * per_unit).round() as i64).map_err(|_| refused())
}

/// Converts electrical degrees and rev/s to a rotor position.
fn position(angle: f64, speed: f64, tick_rate: u32) -> PyResult<Position> {
    let angle = error::finite("angle", angle, "degrees")?;
    let most = f64::from(tick_rate) / 12.0;
    let speed = error::number(
        "speed",
        speed,
        "rev/s",
        &format!("from {} to {most}, a twelfth of the tick rate", -most),
        |speed| speed.abs() <= most,
    )?;
    Ok(Position {
        angle: ((angle / 360.0).rem_euclid(1.0) * TURN) as u64 as u32,
        speed: (speed / f64::from(tick_rate) * TURN).round() as i32,
    })
}

/// Converts a turn to electrical degrees, 0 to 360.
fn degrees(turn: u32) -> f64 {
    f64::from(turn) * 360.0 / TURN
}

const fn direction(reverse: bool) -> Direction {
    if reverse { Direction::Reverse } else { Direction::Forward }
}

/// Returns the step with this number.
fn step(number: u8) -> PyResult<Step> {
    let most = Step::ALL.len() - 1;
    let found = Step::ALL.get(usize::from(number)).copied();
    found.ok_or_else(|| error::parameter(format!("step {number}: must be a whole number from 0 to {most}")))
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
