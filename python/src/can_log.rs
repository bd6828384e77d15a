//! Logs of a CAN bus as columns.

use crate::error::{self, Given};
use narx_core::motor::FaultWord;
use narx_core::node::Diagnostics;
use narx_host::can_log::{CanLog, Config, Ends, Kind, Logged, Signal, Table, Values, flag};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::pybacked::{PyBackedBytes, PyBackedStr};
use pyo3::types::PyDict;
use std::sync::{Mutex, PoisonError};
use std::thread;

/// Reader of a log; `finish` returns the result.
#[pyclass(module = "narx._core", frozen)]
pub(crate) struct LogReader(Mutex<CanLog>);

/// A frame from another reader: time, channel, bits of `frame_flags`, identifier, length, data.
type Passed = (f64, PyBackedStr, u8, u32, u8, PyBackedBytes);
/// A signal: name, unit, and the meanings of its numbers.
type Described = (&'static str, &'static str, Vec<(u16, &'static str)>);
/// A table: name, true if a device sends the message, time, signals, their columns.
type Columns<'py> = (String, bool, Bound<'py, PyArray1<f64>>, Vec<(Described, Bound<'py, PyAny>)>);
/// Result of a reader: columns of the frames by name, names of the channels, tables, lines that are no frame,
/// number of lines.
type Read<'py> =
    (Bound<'py, PyDict>, Vec<String>, Vec<Columns<'py>>, Vec<(usize, String, &'static str)>, usize);

#[pymethods]
impl LogReader {
    /// slave, monitor: addresses of the drive and its master; `None` for any. encoders: node-ids of
    /// TX-Drivers whose PDOs of 8 bytes contain the encoder's value.
    #[new]
    fn new(slave: Option<Given>, monitor: Option<Given>, encoders: Vec<Given>) -> PyResult<Self> {
        let address = |name: &str, value: Option<Given>| {
            value.map(|value| error::whole(name, value, "", 0, u8::MAX)).transpose()
        };
        let ends = Ends { slave: address("slave", slave)?, monitor: address("monitor", monitor)? };
        let encoders = encoders.into_iter().try_fold(0, |bits, node| {
            let node: u8 = error::whole("encoders", node, "", 1, 127)?;
            PyResult::Ok(bits | 1_u128 << node)
        })?;
        Ok(Self(Mutex::new(CanLog::new(Config { ends, encoders }))))
    }

    /// Reads the next part of a log of can-utils, cut anywhere, on `threads` threads or on every processor.
    #[pyo3(signature = (text, threads=None))]
    fn candump(&self, py: Python<'_>, text: &[u8], threads: Option<usize>) {
        let threads = threads.unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from));
        py.detach(|| self.0.lock().unwrap_or_else(PoisonError::into_inner).feed_candump(text, threads));
    }

    /// Takes frames in the order of their log.
    fn frames(&self, frames: Vec<Passed>) {
        let mut log = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for (time, channel, flags, id, dlc, data) in frames {
            let channel = log.frames.channel(&channel);
            log.push(&Logged { time, channel, flags, id, dlc, data: &data });
        }
    }

    /// Returns the result; the columns move into numpy, and the reader is empty afterwards.
    fn finish<'py>(&self, py: Python<'py>) -> PyResult<Read<'py>> {
        let mut log = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        log.end_candump();
        let CanLog { frames, tables, errors, lines, .. } = log.take();
        drop(log);
        let columns = PyDict::new(py);
        let width = frames.long.iter().map(|(_, data)| data.len()).max().unwrap_or(8);
        let rows = frames.data.len();
        columns.set_item("data", data(py, frames.data, &frames.long, width)?.reshape([rows, width])?)?;
        columns.set_item("time", frames.time.into_pyarray(py))?;
        columns.set_item("id", frames.id.into_pyarray(py))?;
        columns.set_item("flags", frames.flags.into_pyarray(py))?;
        columns.set_item("channel", frames.channel.into_pyarray(py))?;
        columns.set_item("dlc", frames.dlc.into_pyarray(py))?;
        columns.set_item("message", frames.message.into_pyarray(py))?;
        let tables = tables.into_iter().map(|Table { name, from_device, time, signals, columns }| {
            let columns =
                signals.iter().map(described).zip(columns.into_iter().map(|values| array(py, values)));
            (name, from_device, time.into_pyarray(py), columns.collect())
        });
        let errors = errors.into_iter().map(|error| (error.line, error.text, error.reason));
        Ok((columns, frames.channels, tables.collect(), errors.collect(), lines))
    }
}

/// Bits of a frame's flags by name.
#[pyfunction]
pub(crate) fn frame_flags() -> Vec<(&'static str, u8)> {
    flag::ALL.to_vec()
}

/// Values of the frames' column "message" for frames in no table: unknown, malformed, error.
#[pyfunction]
pub(crate) fn frame_kinds() -> (u8, u8, u8) {
    (Kind::Unknown as u8, Kind::Malformed as u8, Kind::Error as u8)
}

/// Every fault with its bit in the fault word.
#[pyfunction]
pub(crate) fn fault_bits() -> Vec<(String, u32)> {
    FaultWord::all().iter_names().map(|(name, flag)| (name.to_ascii_lowercase(), flag.bits())).collect()
}

/// Every diagnostic with its bit in parameter 304.
#[pyfunction]
pub(crate) fn diagnostic_bits() -> Vec<(String, u16)> {
    Diagnostics::all().iter_names().map(|(name, flag)| (name.to_ascii_lowercase(), flag.bits())).collect()
}

fn described(signal: &Signal) -> Described {
    (signal.name, signal.unit, signal.names.clone())
}

fn array(py: Python<'_>, values: Values) -> Bound<'_, PyAny> {
    match values {
        Values::Quantity(values) => values.into_pyarray(py).into_any(),
        Values::Number(values) => values.into_pyarray(py).into_any(),
        Values::Code(values) => values.into_pyarray(py).into_any(),
        Values::Flag(values) => values.into_pyarray(py).into_any(),
        Values::Faults(values) => values.into_pyarray(py).into_any(),
    }
}

/// Returns the data of frames, `width` bytes each.
fn data<'py>(
    py: Python<'py>,
    first: Vec<[u8; 8]>,
    long: &[(usize, Box<[u8]>)],
    width: usize,
) -> PyResult<Bound<'py, PyArray1<u8>>> {
    if width == 8 {
        return Ok(first.into_flattened().into_pyarray(py));
    }
    let mut all = vec![0; first.len() * width];
    all.chunks_exact_mut(width).zip(&first).for_each(|(row, data)| row[..8].copy_from_slice(data));
    for (row, data) in long {
        all[row * width..][..data.len()].copy_from_slice(data);
    }
    Ok(all.into_pyarray(py))
}
