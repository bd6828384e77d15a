//! Master of a TX-Driver: on the bus of a bench, or one whose frames Python carries.

use crate::error::{self, Given};
use crate::frame;
use narx_core::bus::Frame;
use narx_core::bus::eddycan::{Channels, ErrorCode, Layout, NmtCommand, NmtState, NodeId, PdoKind, Reading};
use narx_core::eddycan::{Entry, OBJECTS, Object};
use narx_core::master::NotTaken;
use narx_core::master::eddycan::{Config, Request, RequestError, TxMaster as Core};
use numpy::IntoPyArray;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

/// The master of a node, at the other end of its bus. Times are seconds from any beginning.
#[pyclass(module = "narx._core", frozen)]
pub(crate) struct TxMaster(Arc<Mutex<Station>>);

/// A master with its received readings and errors.
pub(crate) struct Station {
    master: Core,
    /// Latest time that was passed in, microseconds.
    now: u64,
    /// The last reading that came on request (PDO3).
    asked: Option<(Reading, PdoKind, u64)>,
    /// Every reading since `keep`; `None` if they are not kept.
    rows: Option<Vec<(u64, Reading)>>,
    errors: BTreeSet<u16>,
}

/// The last positions, mm, the encoder's counts, a linear encoder's position, mm, their trigger, and the time
/// of reception, s.
type Last = ([f64; 2], i32, Option<f64>, String, f64);

impl Station {
    pub(crate) fn handle_frame(&mut self, frame: &Frame, now: u64) {
        self.now = self.now.max(now);
        let (before, errors) = (self.master.reading(), self.master.report().errors);
        self.master.handle_frame(frame, self.now);
        if let Some((reading, kind, time)) = self.master.reading().filter(|now| Some(*now) != before) {
            if kind == PdoKind::Remote {
                self.asked = Some((reading, kind, time));
            }
            if let Some(rows) = &mut self.rows {
                rows.push((time, reading));
            }
        }
        let report = self.master.report();
        if report.errors != errors {
            self.errors.extend(report.last_error);
        }
    }

    fn last(&self, (reading, kind, time): (Reading, PdoKind, u64)) -> Last {
        let encoder = self.master.report().encoder;
        let position = encoder.position(&reading).map(frame::float);
        (
            millimetres(&reading),
            encoder.counts(&reading),
            position,
            crate::state::words(&kind),
            time as f64 / 1e6,
        )
    }

    pub(crate) fn poll_frame(&mut self, now: u64) -> Option<Frame> {
        self.now = self.now.max(now);
        self.master.poll_frame(self.now)
    }
}

#[pymethods]
impl TxMaster {
    /// Makes a master on no bus. timeout: s.
    #[new]
    #[pyo3(signature = (node_id, channels, timeout))]
    fn new(node_id: Given, channels: Given, timeout: Given) -> PyResult<Self> {
        Self::with_station(node_id, channels, timeout)
    }

    /// Takes a frame that arrived at `now`.
    #[pyo3(signature = (now, id, extended, remote, data))]
    fn handle_frame(&self, now: f64, id: u32, extended: bool, remote: bool, data: &[u8]) -> PyResult<()> {
        let frame = frame::new(id, extended, remote, data)?;
        self.with(|station| station.handle_frame(&frame, microseconds(now)));
        Ok(())
    }

    /// Returns the next frame that is due at `now`: id, extended, remote, data. A bench sends the frames of
    /// its masters itself.
    fn poll_frame<'py>(&self, py: Python<'py>, now: f64) -> Option<frame::Parts<'py>> {
        let frame = self.with(|station| station.poll_frame(microseconds(now)))?;
        Some(frame::parts(py, &frame))
    }

    /// Returns the latest time of the next poll, s.
    fn next_poll(&self, now: f64) -> f64 {
        self.with(|station| station.master.next_poll(microseconds(now))) as f64 / 1e6
    }

    /// Commands the node: "start", "stop", "pre-operational" or "reset".
    fn command(&self, command: &str) -> PyResult<()> {
        let commands = [
            ("start", NmtCommand::Start),
            ("stop", NmtCommand::Stop),
            ("pre-operational", NmtCommand::PreOperational),
            ("reset", NmtCommand::Reset),
        ];
        let command = error::choice("command", command, &commands)?;
        self.with(|station| station.master.command(command)).map_err(not_taken)
    }

    /// True once every command has been sent.
    #[getter]
    fn has_sent(&self) -> bool {
        self.with(|station| station.master.has_sent())
    }

    /// Sends a SYNC.
    fn sync(&self) -> PyResult<()> {
        self.with(|station| station.master.sync()).map_err(not_taken)
    }

    /// Requests PDO3.
    fn ask_positions(&self) -> PyResult<()> {
        self.with(|station| station.master.ask_positions()).map_err(not_taken)
    }

    /// Queues a request that reads an entry, or writes it if `value` is given.
    #[pyo3(signature = (index, subindex, value=None))]
    fn request(&self, index: u16, subindex: u8, value: Option<u32>) -> PyResult<()> {
        let entry = Entry::find(index, subindex).map_err(error::parameter)?;
        let request = value.map_or(Request::Read(entry), |value| Request::Write(entry, value));
        self.with(|station| station.master.request(request)).map_err(not_taken)
    }

    /// Returns the value that was read or written, once the answer has come.
    fn poll_answer(&self, py: Python<'_>) -> PyResult<Option<u32>> {
        let Some(answer) = self.with(|station| station.master.poll_answer()) else { return Ok(None) };
        let (Request::Read(entry) | Request::Write(entry, _)) = answer.request;
        let Object { index, name, .. } = entry.object();
        let message = |error| format!("node {}, {index:04X}h \"{name}\": {error}", self.node_id());
        answer.result.map(Some).map_err(|error| match error {
            RequestError::NoAnswer => error::no_answer(message(error)),
            RequestError::Refused(code) => error::abort(py, message(error), code as u32),
            RequestError::RefusedOtherwise { code } => error::abort(py, message(error), code),
        })
    }

    /// The last positions, mm, counts, a linear encoder's position, mm, their trigger ("timer", "sync",
    /// "remote") and the time of reception, s.
    #[getter]
    fn reading(&self) -> Option<Last> {
        self.with(|station| station.master.reading().map(|reading| station.last(reading)))
    }

    /// The last positions that came on request, in the form of `reading`.
    #[getter]
    fn asked(&self) -> Option<Last> {
        self.with(|station| station.asked.map(|reading| station.last(reading)))
    }

    /// Starts to keep every reading, or stops it.
    fn keep(&self, keep: bool) {
        self.with(|station| station.rows = keep.then(Vec::new));
    }

    /// Returns the kept readings: columns by name. Time in s, positions in mm.
    fn take_rows<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let rows = self.with(|station| station.rows.take()).unwrap_or_default();
        let columns = PyDict::new(py);
        let column =
            |of: &dyn Fn(&(u64, Reading)) -> f64| rows.iter().map(of).collect::<Vec<f64>>().into_pyarray(py);
        columns.set_item("time", column(&|(time, _)| *time as f64 / 1e6))?;
        columns.set_item("position_1", column(&|(_, reading)| millimetres(reading)[0]))?;
        let layout = self.with(|station| station.master.config().layout);
        if layout.channels == Channels::Dual {
            columns.set_item("position_2", column(&|(_, reading)| millimetres(reading)[1]))?;
        }
        if layout.encoder {
            let encoder = self.with(|station| station.master.report().encoder);
            columns.set_item("encoder", column(&|(_, reading)| encoder.counts(reading).into()))?;
            let position =
                |(_, reading): &(u64, Reading)| encoder.position(reading).map_or(f64::NAN, frame::float);
            if encoder.position(&Reading::default()).is_some() {
                columns.set_item("encoder_position", column(&position))?;
            }
        }
        Ok(columns)
    }

    /// State in the last heartbeat.
    #[getter]
    fn state(&self) -> Option<u8> {
        self.with(|station| station.master.report().state).map(|state| state as u8)
    }

    /// Returns whether a frame of the node was received within 5 s.
    fn is_present(&self, now: f64) -> bool {
        self.with(|station| station.master.is_present(station.now.max(microseconds(now))))
    }

    /// Number of boot-up messages.
    #[getter]
    fn boots(&self) -> u32 {
        self.with(|station| station.master.report().boots)
    }

    /// Number of the node's frames that cannot be decoded: most likely PDOs of another layout.
    #[getter]
    fn malformed(&self) -> u32 {
        self.with(|station| station.master.report().malformed)
    }

    /// Errors that the node has reported (Table 13): code and meaning, "" if the table does not list it.
    fn errors(&self) -> Vec<(u16, &'static str)> {
        let codes = self.with(|station| station.errors.clone());
        codes.into_iter().map(|code| (code, ErrorCode::decode(code).map_or("", ErrorCode::meaning))).collect()
    }

    /// Clears the errors.
    fn clear_errors(&self) {
        self.with(|station| station.errors.clear());
    }

    /// Node-id of the node.
    #[getter]
    fn node_id(&self) -> u8 {
        self.with(|station| station.master.config().node.raw())
    }

    /// Changes the node-id that this master uses.
    #[setter]
    fn set_node_id(&self, node_id: Given) -> PyResult<()> {
        let node = node(node_id)?;
        self.with(|station| {
            station.master = Core::new(Config { node, ..*station.master.config() });
        });
        Ok(())
    }

    /// True if PDOs carry the encoder, as far as is known.
    #[getter]
    fn encoder(&self) -> bool {
        self.with(|station| station.master.config().layout.encoder)
    }
}

impl TxMaster {
    pub(crate) fn with_station(node_id: Given, channels: Given, timeout: Given) -> PyResult<Self> {
        let layout = Layout { channels: self::channels(channels)?, encoder: false };
        let timeout = microseconds(error::within("timeout", timeout, "s", 0.003, 10.0)?);
        let config = Config { timeout, ..Config::new(node(node_id)?, layout) };
        let master = Core::new(config);
        Ok(Self(Arc::new(Mutex::new(Station {
            master,
            now: 0,
            asked: None,
            rows: None,
            errors: BTreeSet::new(),
        }))))
    }

    pub(crate) fn station(&self) -> Arc<Mutex<Station>> {
        Arc::clone(&self.0)
    }

    /// Locks the station; it is never locked for longer than one frame takes.
    fn with<T>(&self, act: impl FnOnce(&mut Station) -> T) -> T {
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

pub(crate) fn node(node_id: Given) -> PyResult<NodeId> {
    let refused = || error::parameter("node_id: must be a whole number from 1 to 127");
    NodeId::new(error::whole("node_id", node_id, "", 1, 127)?).ok_or_else(refused)
}

pub(crate) fn channels(channels: Given) -> PyResult<Channels> {
    match error::number("channels", channels, "", "1 or 2", |channels| channels == 1.0 || channels == 2.0)? {
        1.0 => Ok(Channels::Single),
        _ => Ok(Channels::Dual),
    }
}

/// Returns the object dictionary (Table 4) in order: a dictionary each, for `narx.objects.Object`.
#[pyfunction]
pub(crate) fn tx_objects(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    OBJECTS.iter().map(|row| object(py, row)).collect()
}

fn object<'py>(py: Python<'py>, row: &Object) -> PyResult<Bound<'py, PyDict>> {
    // The unit is a fraction of the measuring range.
    let (unit, scale) = match row.unit {
        "2^-30" => ("", 2.0_f64.powi(-30)),
        "-" => ("", 1.0),
        unit => (unit, 1.0),
    };
    let name = row.subindex.map_or(row.name.to_owned(), |channel| format!("{} {channel}", row.name));
    let fields = PyDict::new(py);
    fields.set_item("index", row.index)?;
    fields.set_item("subindex", row.subindex.unwrap_or(0))?;
    fields.set_item("name", name)?;
    fields.set_item("unit", unit)?;
    fields.set_item("scale", scale)?;
    fields.set_item("min", f64::from(row.min) * scale)?;
    fields.set_item("max", f64::from(row.max) * scale)?;
    fields.set_item("factory", f64::from(row.default) * scale)?;
    fields.set_item("access", row.access.label())?;
    fields.set_item("acts", if row.restart { "after a restart" } else { "at once" })?;
    fields.set_item("description", row.description)?;
    Ok(fields)
}

/// Builds `narx.NodeState`: an `IntEnum` with the numbers of Table 12.
pub(crate) fn states(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let members = NmtState::ALL.map(|state| (crate::state::words(&state), state as u8));
    let doc = "States of a TX-Driver, with the numbers of its heartbeats (eddyCAN specification, Table 12).";
    crate::state::enumeration(py, "narx", "NodeState", doc, &members)
}

fn millimetres(reading: &Reading) -> [f64; 2] {
    reading.positions.map(|position| f64::from(position.raw()) / f64::from(1 << 27))
}

fn not_taken(refused: NotTaken) -> PyErr {
    error::refused(refused)
}

fn microseconds(seconds: f64) -> u64 {
    (seconds * 1e6).round() as u64
}
