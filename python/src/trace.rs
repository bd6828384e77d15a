//! Traces: named columns as numpy arrays.

use narx_sim::trace::{Column, Trace};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Returns arrays and units by name. The columns move into numpy; nothing is copied.
pub(crate) fn columns(py: Python<'_>, table: Trace) -> PyResult<(Bound<'_, PyDict>, Bound<'_, PyDict>)> {
    let (columns, units) = (PyDict::new(py), PyDict::new(py));
    let signals = table.signals().to_vec();
    for (signal, column) in signals.iter().zip(table.into_columns()) {
        units.set_item(signal.name, signal.unit)?;
        match column {
            Column::Single(values) => columns.set_item(signal.name, values.into_pyarray(py))?,
            Column::Double(values) => columns.set_item(signal.name, values.into_pyarray(py))?,
        }
    }
    Ok((columns, units))
}
