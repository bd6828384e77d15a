//! The parameters' dictionary, and values in their units.

use crate::error;
use crate::frame;
use narx_core::bus::narmotion::SIGNALS;
use narx_core::dictionary::{Decimal, Dictionary, Effect, Parameter};
use narx_core::motor::signal::DRIVE_SIGNALS;
use narx_sim::engineering;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Every parameter in the order of the numbers: a dictionary each, as `narx.parameters.Row` takes it.
#[pyfunction]
pub(crate) fn parameters(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    Dictionary::rows().map(|row| parameter(py, row)).collect()
}

fn parameter<'py>(py: Python<'py>, row: &Parameter) -> PyResult<Bound<'py, PyDict>> {
    let value = |digits| frame::float(Decimal { digits, exponent: row.exponent });
    let fields = PyDict::new(py);
    fields.set_item("number", row.number)?;
    fields.set_item("name", row.name())?;
    fields.set_item("category", row.category.label())?;
    fields.set_item("unit", if row.unit() == "-" { "" } else { row.unit() })?;
    fields.set_item("type", row.kind.label())?;
    fields.set_item("scale", value(1))?;
    fields.set_item("min", value(row.min()))?;
    fields.set_item("max", value(row.max()))?;
    fields.set_item("factory", value(row.default()))?;
    fields.set_item("access", row.access.label())?;
    fields.set_item("command", row.command)?;
    fields
        .set_item("acts", if row.effect == Effect::Immediately { "at once" } else { row.effect.label() })?;
    fields.set_item("description", row.description())?;
    Ok(fields)
}

/// The raw value of a parameter's value in its unit, to the nearest step of its scale.
#[pyfunction]
pub(crate) fn to_raw(number: u16, value: f64) -> PyResult<i64> {
    engineering::raw(number, value).map_err(error::parameter)
}

/// A parameter's raw value in its unit; whole numbers stay whole.
#[pyfunction]
pub(crate) fn from_raw<'py>(py: Python<'py>, number: u16, raw: i64) -> PyResult<Bound<'py, PyAny>> {
    let row = Dictionary::row(number);
    match row.filter(|row| row.exponent != 0) {
        Some(row) => Ok(engineering::to_unit(row, raw).into_pyobject(py)?.into_any()),
        None => Ok(raw.into_pyobject(py)?.into_any()),
    }
}

/// Signals of the virtual scope in the order of their bits: name, unit, value of a sample of 1.
#[pyfunction]
pub(crate) fn scope_signals() -> Vec<(&'static str, &'static str, f64)> {
    let rows = DRIVE_SIGNALS.iter();
    rows.map(|row| (row.name, if row.unit == "-" { "" } else { row.unit }, frame::float(row.base))).collect()
}

/// Signals of the measurements: name, opcode, word, unit, value of a raw 1.
#[pyfunction]
pub(crate) fn measurement_signals() -> Vec<(&'static str, u16, u8, &'static str, f64)> {
    let value = |exponent| frame::float(Decimal { digits: 1, exponent });
    let unit = |unit| if unit == "-" { "" } else { unit };
    let rows = SIGNALS.iter();
    rows.map(|row| (row.name, row.opcode.raw(), row.word, unit(row.unit), value(row.exponent))).collect()
}

/// The records of a log download: index, time in s, and (what, raw value) of each; `None` where the drive could read none.
#[pyfunction]
pub(crate) fn log_records(data: &[u8], size: usize) -> Vec<Option<LogRecord>> {
    let record = |bytes: &[u8]| {
        let record = narx_core::storage::Record::parse(bytes)?;
        let entry = record.entry();
        Some((record.index(), f64::from(entry.time) / 1000.0, entry.values.to_vec()))
    };
    data.chunks_exact(size.max(1)).map(record).collect()
}

type LogRecord = (u32, f64, Vec<(u16, i32)>);
