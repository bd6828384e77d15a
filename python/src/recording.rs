//! Replaying recordings.

use crate::error;
use crate::trace::Trace;
use narx_core::motor::{Drive, Samples};
use narx_core::recording::{Outputs, Player, Recording, ReplayError};
use narx_sim::bench::SIGNALS;
use narx_sim::trace::{Signal, Trace as Table};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;

/// A recording that ran again: a trace of what the drive answered, and whether it was the same.
#[pyclass(module = "narx", frozen, extends = Trace)]
pub(crate) struct Replay {
    /// Ticks that ran.
    #[pyo3(get)]
    ticks: u64,
    /// Digest of the outputs now.
    #[pyo3(get)]
    digest: u64,
    /// Digest of the outputs when they were recorded; `None` when only a part ran.
    #[pyo3(get)]
    recorded_digest: Option<u64>,
    /// What the last tick answered, every field in raw bits; `None` when none ran.
    #[pyo3(get)]
    outputs: Option<String>,
    /// The recording's label.
    #[pyo3(get)]
    label: String,
    /// Whether the version that recorded behaves as this one. If not, the digests may rightly differ.
    #[pyo3(get)]
    same_behaviour: bool,
}

#[pymethods]
impl Replay {
    /// Whether every output was the same, bit for bit; `None` when only a part ran.
    #[getter]
    fn identical(&self) -> Option<bool> {
        self.recorded_digest.map(|recorded| recorded == self.digest)
    }

    fn __repr__(&self) -> String {
        let verdict = match self.identical() {
            Some(true) => "identical",
            Some(false) => "not identical",
            None => "a part of the recording",
        };
        format!("<narx.Replay of {} ticks: digest {:016x}, {verdict}>", self.ticks, self.digest)
    }
}

/// Runs a drive through a recording, or its first `until` ticks, and compares what it answers with what was recorded.
///
/// `recording` is the recording's bytes, or the path of a file.
#[pyfunction]
#[pyo3(signature = (recording, until=None))]
pub(crate) fn replay<'py>(
    py: Python<'py>,
    recording: &Bound<'py, PyAny>,
    until: Option<i64>,
) -> PyResult<Bound<'py, Replay>> {
    let refused = |ticks| error::parameter(format!("until {ticks}: must be a number of ticks, 0 or more"));
    let until = until.map(|ticks| u64::try_from(ticks).map_err(|_| refused(ticks))).transpose()?;
    let bytes = match recording.extract::<PyBackedBytes>() {
        Ok(bytes) => bytes,
        // Python's own reading tells of a missing file with its name.
        Err(_) => {
            let path = py.import("pathlib")?.getattr("Path")?.call1((recording,))?;
            path.call_method0("read_bytes")?.extract()?
        }
    };
    let (replay, table) = py.detach(|| play(&bytes, until)).map_err(error::recording)?;
    let trace = Trace::new(py, table, bytes.into_pyobject(py)?)?;
    Bound::new(py, PyClassInitializer::from(trace).add_subclass(replay))
}

fn play(bytes: &[u8], until: Option<u64>) -> Result<(Replay, Table), ReplayError> {
    let recording = Recording::open(bytes)?;
    let rate = f64::from(recording.header().tick_rate.max(1));
    let mut player = Player::<Drive>::new(&recording)?;
    let mut table = Table::new(&signals());
    let (mut ticks, mut last) = (0, None);
    while until.is_none_or(|until| ticks < until)
        && let Some((samples, outputs)) = player.step()?
    {
        // As many values as signals: both stand in this file.
        let _ = table.push(&row(rate, &samples, &outputs, player.drive()));
        ticks += 1;
        last = Some(outputs);
    }
    let recorded_digest = match until {
        None => Some(recording.verify()?.digest),
        Some(_) => None,
    };
    let replay = Replay {
        ticks,
        digest: player.digest(),
        recorded_digest,
        outputs: last.map(|outputs| outputs.to_string()),
        label: recording.header().label.to_owned(),
        same_behaviour: recording.same_behaviour(),
    };
    Ok((replay, table))
}

/// What a drive alone knows of the signals of a bench.
const NAMES: [&str; 6] = ["time", "state", "duty", "hall", "step", "limiter"];

fn signals() -> Vec<Signal> {
    NAMES.iter().filter_map(|name| SIGNALS.iter().find(|signal| signal.name == *name).copied()).collect()
}

/// The values of [`NAMES`], as the bench traces them.
fn row(rate: f64, samples: &Samples, outputs: &Outputs, drive: &Drive) -> [f64; NAMES.len()] {
    [
        // A row tells how its tick ends.
        (outputs.tick + 1) as f64 / rate,
        f64::from(drive.state() as u8),
        f64::from(outputs.command.duty.to_bits()) / 32_768.0,
        f64::from(samples.hall),
        f64::from(outputs.command.step as u8),
        f64::from(drive.limiter() as u8),
    ]
}
