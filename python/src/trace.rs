//! Traces: named columns as numpy arrays.

use crate::error;
use narx_sim::trace::{Column, Trace as Table};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

/// A table of signals, a row per control tick; `trace["speed"]` is a numpy array.
#[pyclass(module = "narx", frozen, subclass, mapping)]
pub(crate) struct Trace {
    /// Arrays by name.
    columns: Py<PyDict>,
    /// Units by name.
    signals: Py<PyDict>,
    rows: usize,
    recording: Py<PyBytes>,
}

impl Trace {
    /// Moves the columns into numpy; nothing is copied.
    pub(crate) fn new(py: Python<'_>, table: Table, recording: Bound<'_, PyBytes>) -> PyResult<Self> {
        let (columns, signals) = (PyDict::new(py), PyDict::new(py));
        let rows = table.len();
        let names = table.signals().to_vec();
        for (signal, column) in names.iter().zip(table.into_columns()) {
            signals.set_item(signal.name, signal.unit)?;
            match column {
                Column::Single(values) => columns.set_item(signal.name, values.into_pyarray(py))?,
                Column::Double(values) => columns.set_item(signal.name, values.into_pyarray(py))?,
            }
        }
        Ok(Self { columns: columns.unbind(), signals: signals.unbind(), rows, recording: recording.unbind() })
    }
}

#[pymethods]
impl Trace {
    /// Time of each row since power-up, s.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.__getitem__(py, "time")
    }

    /// The signals in order: name -> unit; "" for plain numbers.
    #[getter]
    fn signals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.signals.bind(py).copy()
    }

    /// The values of a signal, a row per control tick.
    fn __getitem__<'py>(&self, py: Python<'py>, signal: &str) -> PyResult<Bound<'py, PyAny>> {
        let columns = self.columns.bind(py);
        if let Some(column) = columns.get_item(signal)? {
            return Ok(column);
        }
        let names: Vec<String> = columns.keys().extract()?;
        let hint = error::suggestion(py, signal, names.iter().map(String::as_str));
        Err(error::signal(format!("there is no signal \"{signal}\"{hint}; there are {}", names.join(", "))))
    }

    fn __contains__(&self, py: Python<'_>, signal: &Bound<'_, PyAny>) -> PyResult<bool> {
        self.columns.bind(py).contains(signal)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(self.columns.bind(py).try_iter()?.into_any())
    }

    /// Number of rows.
    fn __len__(&self) -> usize {
        self.rows
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let names: Vec<String> = self.columns.bind(py).keys().extract()?;
        Ok(format!("<narx.Trace of {} rows: {}>", self.rows, names.join(", ")))
    }

    /// The columns as a pandas data frame.
    fn to_pandas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("pandas")?.getattr("DataFrame")?.call1((self.columns.bind(py),))
    }

    /// What the drive was given since it last booted, up to the end of this trace: what `replay` takes, and a `.narxrec`
    /// file holds.
    fn recording<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        self.recording.bind(py).clone()
    }
}
