//! Replaying recordings.

use crate::error;
use crate::trace;
use narx_core::motor::{Drive, Samples};
use narx_core::recording::{Outputs, Player, Recording, ReplayError};
use narx_sim::bench::SIGNALS;
use narx_sim::trace::{Signal, Trace as Table};
use pyo3::prelude::*;
use pyo3::pybacked::PyBackedBytes;
use pyo3::types::PyDict;

/// What ran again: columns, units, ticks, digest, recorded digest (`None` of a part), what the last tick answered, label, and whether
/// the recording version behaves as this one.
type Replayed<'py> =
    (Bound<'py, PyDict>, Bound<'py, PyDict>, u64, u64, Option<u64>, Option<String>, String, bool);

struct Replay {
    ticks: u64,
    digest: u64,
    recorded_digest: Option<u64>,
    outputs: Option<String>,
    label: String,
    same_behaviour: bool,
}

/// Runs a drive through a recording, or its first `until` ticks, and compares what it answers with what was recorded.
#[pyfunction]
#[pyo3(signature = (recording, until=None))]
pub(crate) fn replay<'py>(
    py: Python<'py>,
    recording: PyBackedBytes,
    until: Option<i64>,
) -> PyResult<Replayed<'py>> {
    let refused = |ticks| error::parameter(format!("until {ticks}: must be a number of ticks, 0 or more"));
    let until = until.map(|ticks| u64::try_from(ticks).map_err(|_| refused(ticks))).transpose()?;
    let (replay, table) = py.detach(|| play(&recording, until)).map_err(error::recording)?;
    let (columns, units) = trace::columns(py, table)?;
    let Replay { ticks, digest, recorded_digest, outputs, label, same_behaviour } = replay;
    Ok((columns, units, ticks, digest, recorded_digest, outputs, label, same_behaviour))
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
