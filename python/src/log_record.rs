//! Records of the log.

use pyo3::prelude::*;

/// Decodes the records of a log download: index, time in s, and (what, raw value) of each; `None` for a
/// record that the drive could not read.
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
