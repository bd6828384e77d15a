//! Replay of recordings, and conversion of the scope's records to recordings.

use crate::error::{self, Given};
use crate::trace;
use narx_core::recording::{
    BEHAVIOUR_VERSION, ReplayError, header, record_scoped, replay_any, replay_any_until,
};
use narx_sim::recording::RecordingBuffer;
use narx_sim::replayed::{Replayed, replayed};
use narx_sim::trace::Trace;
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::{PyBytes, PyDict};

/// Result of a replay: columns, units, ticks, digest, recorded digest (`None` for a part), outputs of the
/// last tick, label, and true if the recording version has the same behaviour as this one.
type Answer<'py> =
    (Bound<'py, PyDict>, Bound<'py, PyDict>, u64, u64, Option<u64>, Option<String>, String, bool);

/// Runs a drive through a recording, or its first `until` ticks, and compares its outputs with the recorded
/// ones; or runs a node or TX-Driver through its transcript.
#[pyfunction]
#[pyo3(signature = (recording, until=None))]
pub(crate) fn replay<'py>(
    py: Python<'py>,
    recording: PyBackedBytes,
    until: Option<Given>,
) -> PyResult<Answer<'py>> {
    let until = until.map(|ticks| error::whole("until", ticks, "", 0, u64::MAX)).transpose()?;
    let answer = py.detach(|| run(&recording, until)).map_err(error::recording)?;
    let Replayed { trace, ticks, digest, recorded_digest, outputs, label, same_behaviour } = answer;
    let (columns, units) = trace::columns(py, trace)?;
    Ok((columns, units, ticks, digest, recorded_digest, outputs, label, same_behaviour))
}

/// Runs a recording or a transcript. A transcript has no table: its calls have other shapes than columns.
fn run(bytes: &[u8], until: Option<u64>) -> Result<Replayed, ReplayError> {
    let header = header(bytes)?;
    if !header.kind.is_transcript() {
        return replayed(bytes, until);
    }
    let (ticks, digest, recorded_digest) = match until {
        None => replay_any(bytes).map(|found| (found.ticks, found.digest, Some(found.recorded_digest)))?,
        Some(calls) => replay_any_until(bytes, calls).map(|found| (found.ticks, found.digest, None))?,
    };
    Ok(Replayed {
        trace: Trace::new(&[]),
        ticks,
        digest,
        recorded_digest,
        outputs: None,
        label: header.label.into(),
        same_behaviour: header.behaviour_version == BEHAVIOUR_VERSION,
    })
}

/// Converts a scope's record of inputs (big-endian words, as downloaded) to a recording. Returns the
/// recording, the number of its first tick since power-up, and whether its replay agrees with the drive's
/// second checkpoint (`None` without one).
#[pyfunction]
pub(crate) fn scope_recording<'py>(
    py: Python<'py>,
    words: PyBackedBytes,
    label: &str,
) -> PyResult<(Bound<'py, PyBytes>, u64, Option<bool>)> {
    let words: Vec<u16> = words.as_chunks().0.iter().map(|word| u16::from_be_bytes(*word)).collect();
    let scoped =
        py.detach(|| record_scoped(&words, label, RecordingBuffer::default())).map_err(error::recording)?;
    Ok((PyBytes::new(py, &scoped.sink.0), scoped.first, scoped.agrees))
}
