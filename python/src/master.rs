//! Master of a drive: that of a bench, or one whose frames Python carries.

use crate::description::{Description, Signal, Tables};
use crate::error::{self, Given};
use crate::frame;
use crate::session::Shared;
use crate::state;
use narx_core::bus::Frame;
use narx_core::bus::narmotion::{Addresses, DigitalOutputs, StatusWord};
use narx_core::master::{
    Answer, Config, Download, ErrorKind, Image, Job, JobError, Master as Core, Received, Request,
    RequestError, ScopeSetup, SpeedLimits, UpdateProgress,
};
use narx_core::motor::{FaultWord, State};
use narx_sim::session::Session;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};

/// The master of a drive, at the other end of its bus. Times are seconds from any beginning.
#[pyclass(module = "narx._core", frozen)]
pub(crate) struct Master {
    host: Host,
    /// Tables of the drive, as known at present.
    tables: Mutex<Arc<Tables>>,
}

/// Place of a master.
enum Host {
    /// On a bench, with its simulated time.
    Bench(Shared),
    /// On no bus: Python passes its frames.
    Free(Arc<Mutex<Free>>),
}

struct Free {
    master: Core,
    /// Latest time that was passed in, microseconds.
    now: u64,
    /// Image of the update.
    image: Vec<u8>,
}

impl Free {
    fn poll_frame(&mut self) -> Option<Frame> {
        let Self { master, now, image } = self;
        master.poll_frame(*now).or_else(|| master.poll_update_frame(*now, image))
    }
}

impl Master {
    pub(crate) fn of_bench(session: Shared) -> Self {
        Self::of(Host::Bench(session))
    }

    fn of(host: Host) -> Self {
        Self { host, tables: Mutex::new(Tables::own()) }
    }

    fn tables(&self) -> Arc<Tables> {
        Arc::clone(&self.tables.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Calls `act` with the master and its time.
    pub(crate) fn with<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&mut Core, u64) -> T + Send) -> T {
        match &self.host {
            Host::Bench(session) => session.with(py, |session| {
                let now = session.bench().now_ns() / 1000;
                act(session.master(), now)
            }),
            Host::Free(free) => py.detach(|| {
                let mut free = free.lock().unwrap_or_else(PoisonError::into_inner);
                let now = free.now;
                act(&mut free.master, now)
            }),
        }
    }

    /// Returns a value that a bench knows exactly; `None` without a bench.
    fn exact<T: Send>(&self, py: Python<'_>, look: impl FnOnce(&Session) -> T + Send) -> Option<T> {
        match &self.host {
            Host::Bench(session) => Some(session.with(py, |session| look(session))),
            Host::Free(_) => None,
        }
    }
}

#[pymethods]
impl Master {
    /// Makes a master on no bus. slave, monitor: addresses of the drive and of this master. setpoint_period,
    /// timeout: s.
    #[new]
    #[pyo3(signature = (slave, monitor, setpoint_period, silent, read_parameters, timeout=Given::Real(0.1)))]
    fn new(
        slave: Given,
        monitor: Given,
        setpoint_period: Given,
        silent: bool,
        read_parameters: bool,
        timeout: Given,
    ) -> PyResult<Self> {
        let address = |name: &str, value: Given| error::whole(name, value, "", 0, u8::MAX);
        let time = |name, value: Given| error::within(name, value, "s", 0.001, 10.0).map(microseconds);
        let config = Config {
            addresses: Addresses { drive: address("slave", slave)?, master: address("monitor", monitor)? },
            setpoint_period: time("setpoint_period", setpoint_period)?,
            timeout: time("timeout", timeout)?,
            silent,
            read_parameters,
            ..Config::default()
        };
        let free = Free { master: Core::new(config), now: 0, image: Vec::new() };
        Ok(Self::of(Host::Free(Arc::new(Mutex::new(free)))))
    }

    /// Takes a frame that arrived at `now`.
    #[pyo3(signature = (now, id, extended, remote, data))]
    fn handle_frame(
        &self,
        py: Python<'_>,
        now: f64,
        id: u32,
        extended: bool,
        remote: bool,
        data: &[u8],
    ) -> PyResult<()> {
        let frame = frame::new(id, extended, remote, data)?;
        self.tell(now);
        self.with(py, |master, now| master.handle_frame(&frame, now));
        Ok(())
    }

    /// Returns the next frame that is due at `now`: id, extended, remote, data. A bench sends the frames of
    /// its master itself.
    fn poll_frame<'py>(&self, py: Python<'py>, now: f64) -> Option<frame::Parts<'py>> {
        self.tell(now);
        let Host::Free(free) = &self.host else { return None };
        let frame = py.detach(|| free.lock().unwrap_or_else(PoisonError::into_inner).poll_frame())?;
        Some(frame::parts(py, &frame))
    }

    /// Returns the latest time of the next poll; infinity if there is none.
    fn next_poll(&self, py: Python<'_>, now: f64) -> f64 {
        self.tell(now);
        match self.with(py, |master, now| master.next_poll(now)) {
            u64::MAX => f64::INFINITY,
            due => seconds(due),
        }
    }

    /// Checks a set-point, rpm, negative in reverse, against the drive's limits in rpm. values: parameters by
    /// number; a bench knows them itself. Returns the number of a parameter that is missing in `values`;
    /// `None` if none is missing and the set-point is allowed. least: 0 if the set-point has no direction.
    /// Warns if the drive runs at one speed, whatever is requested.
    fn check_speed(
        &self,
        py: Python<'_>,
        rpm: Given,
        values: HashMap<u16, i32>,
        least: Option<i32>,
    ) -> PyResult<Option<u16>> {
        let rpm = error::whole("rpm", rpm, "", least.unwrap_or(-RPM_MAX), RPM_MAX)?;
        let missing = Cell::new(None);
        let limits = match &self.host {
            Host::Bench(session) => session.with(py, |session| {
                let parameters = session.bench().node().parameters();
                SpeedLimits::of(|number| parameters.value(number))
            }),
            Host::Free(_) => SpeedLimits::of(|number| {
                let value = values.get(&number).copied();
                if value.is_none() {
                    missing.set(Some(number));
                }
                value
            }),
        };
        match limits.map(|limits| limits.check(rpm)) {
            None => Ok(missing.get()),
            Some(Ok(())) => Ok(None),
            Some(Err(refused)) if refused.is_fixed() => {
                error::warn(py, "SpeedWarning", &refused.to_string()).map(|()| None)
            }
            Some(Err(refused)) => Err(error::parameter(refused)),
        }
    }

    /// Motor mode of the last request word; `None` before the first.
    #[getter]
    fn requested(&self, py: Python<'_>) -> Option<u8> {
        self.with(py, |master, _| master.requested().map(|mode| mode as u8))
    }

    /// Begins a job: "start" at a speed, rpm, negative in reverse, "calibrate hall" or "reboot". `poll_job`
    /// returns its end.
    #[pyo3(signature = (job, rpm=None))]
    fn begin(&self, py: Python<'_>, job: &str, rpm: Option<Given>) -> PyResult<()> {
        let job = match rpm {
            Some(rpm) => Job::Start { rpm: self::rpm(rpm)? },
            None => error::choice("job", job, &JOBS)?,
        };
        self.begin_job(py, job)
    }

    /// Begins a job of the scope or the log: "arm scope", "force scope", "await scope", "capture scope" or
    /// "erase log". setup: channels, samples, prescaler, before, and kind, signal and level of the trigger,
    /// as the parameters have them; within: longest wait for the record, s. `poll_record` returns its end.
    #[pyo3(signature = (job, setup, within))]
    fn begin_record(&self, py: Python<'_>, job: &str, setup: Setup, within: Given) -> PyResult<()> {
        let (channels, samples, prescaler, before, trigger, signal, level) = setup;
        let word = |name, value: Given| error::whole(name, value, "", 0, u16::MAX);
        let setup = ScopeSetup {
            channels,
            samples: word("samples", samples)?,
            prescaler: word("prescaler", prescaler)?,
            before: word("before", before)?,
            trigger,
            signal,
            level,
        };
        let within = microseconds(error::magnitude("timeout", within, "s")?);
        let jobs = [
            ("arm scope", Job::ArmScope(setup)),
            ("force scope", Job::ForceScope),
            ("await scope", Job::AwaitScope { within }),
            ("capture scope", Job::CaptureScope { setup, within }),
            ("erase log", Job::EraseLog),
        ];
        self.begin_job(py, error::choice("job", job, &jobs)?)
    }

    /// Returns whether the job of the motor has ended in success. Raises the error of the job.
    fn poll_job(&self, py: Python<'_>) -> PyResult<bool> {
        self.ended(self.with(py, |master, _| master.poll_job()))
    }

    /// Returns whether the job of the scope or the log has ended in success. Raises the error of the job.
    fn poll_record(&self, py: Python<'_>) -> PyResult<bool> {
        self.ended(self.with(py, |master, _| master.poll_record()))
    }

    /// Requests another speed in the same direction, rpm.
    fn set_speed(&self, py: Python<'_>, rpm: Given) -> PyResult<()> {
        let rpm = error::whole("rpm", rpm, "", 0, u16::MAX)?;
        match &self.host {
            Host::Bench(session) => session.with(py, |session| session.set_speed(rpm)),
            Host::Free(_) => self.with(py, |master, _| master.set_speed(rpm)),
        }
        Ok(())
    }

    /// Requests Standby.
    fn stop(&self, py: Python<'_>) {
        match &self.host {
            Host::Bench(session) => session.with(py, Session::stop),
            Host::Free(_) => self.with(py, |master, _| master.stop()),
        }
    }

    /// Requests a shutdown.
    fn shut_down(&self, py: Python<'_>) {
        self.with(py, |master, _| master.shut_down());
    }

    /// True while a start waits until the drive accepts it.
    #[getter]
    fn start_pending(&self, py: Python<'_>) -> bool {
        let exact = self.exact(py, Session::is_start_pending);
        exact.unwrap_or_else(|| self.with(py, |master, _| master.is_start_pending()))
    }

    /// Magnitude of the set-point, rpm.
    #[getter]
    fn setpoint(&self, py: Python<'_>) -> u16 {
        self.with(py, |master, _| master.setpoint())
    }

    /// True for a master that transmits nothing.
    #[getter]
    fn silent(&self, py: Python<'_>) -> bool {
        self.with(py, |master, _| master.config().silent)
    }

    /// Time between two set-points, s.
    #[getter]
    fn setpoint_period(&self, py: Python<'_>) -> f64 {
        self.with(py, |master, _| seconds(master.config().setpoint_period))
    }

    /// True if a frame of the drive was received within the last 0.5 s, or within three of its broadcast
    /// periods if that is longer.
    #[getter]
    fn connected(&self, py: Python<'_>) -> bool {
        self.with(py, |master, now| master.is_connected(now))
    }

    /// Time at which any message of the drive was last received, s; `None` before the first.
    #[getter]
    fn last_received(&self, py: Python<'_>) -> Option<f64> {
        self.with(py, |master, _| master.report().last.map(seconds))
    }

    /// State of the drive; `None` while unknown. A bench knows it exactly.
    #[getter]
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let exact = self.exact(py, |session| session.bench().status().state);
        let state: Option<State> = exact.or_else(|| self.with(py, |master, _| master.state()));
        state.map(|state| state::member(py, state)).transpose()
    }

    /// Names of the set bits of FAULT_WORD; `None` before the first. A bench knows them exactly.
    #[getter]
    fn faults(&self, py: Python<'_>) -> Option<HashSet<String>> {
        let exact = self.exact(py, |session| session.bench().status().faults);
        let received = || self.with(py, |master, _| master.report().faults.map(|received| received.value));
        exact.or_else(received).map(|faults| names(faults).collect())
    }

    /// The last CRITICAL_FAULT: faults, extended code, and its meaning.
    #[getter]
    fn critical(&self, py: Python<'_>) -> Option<(HashSet<String>, u16, Option<&'static str>)> {
        let Received { value, .. } = self.with(py, |master, _| master.report().critical)?;
        Some((names(value.faults).collect(), value.code, value.cause().map(|cause| cause.meaning)))
    }

    /// The last STATUS_WORD: its fields by the names of PROTOCOL.md; `None` before the first.
    #[getter]
    fn status<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(Received { value, .. }) = self.with(py, |master, _| master.report().status) else {
            return Ok(None);
        };
        frame::status(py, StatusWord::encode(value)).map(Some)
    }

    /// Set-point that the drive has accepted, rpm.
    #[getter]
    fn accepted_speed(&self, py: Python<'_>) -> Option<u16> {
        self.with(py, |master, _| Some(master.report().accepted_speed?.value))
    }

    /// BUILD_INFO: build number, true if built from modified sources, date YYYYMMDD.
    #[getter]
    fn build(&self, py: Python<'_>) -> Option<(u16, bool, u32)> {
        let build = self.with(py, |master, _| master.report().build)?.value;
        Some((build.number, build.modified, build.date))
    }

    /// DEVICE_INFO: releases of hardware and software, serial number, address.
    #[getter]
    fn device(&self, py: Python<'_>) -> Option<(u16, u16, u16, u16)> {
        let device = self.with(py, |master, _| master.report().device)?.value;
        Some((device.hardware, device.software, device.device_number, device.address))
    }

    /// Every signal of the measurements: name, unit, and value with the time of its reception.
    fn measurements(&self, py: Python<'_>) -> Vec<Signal> {
        let tables = self.tables();
        self.with(py, |master, _| tables.measurements(master.measurements()))
    }

    /// Replaces the tables of the drive by those of a description.
    fn describe(&self, description: &Description) {
        *self.tables.lock().unwrap_or_else(PoisonError::into_inner) = description.tables();
    }

    /// Length of the drive's description in words, and its CRC-32 (0 if the drive does not report it); `None`
    /// before it was read.
    #[getter]
    fn description(&self, py: Python<'_>) -> Option<(u16, u32)> {
        let told = self.with(py, |master, _| master.report().description)?.value;
        Some((told.words, told.check))
    }

    /// Time at which the drive last acknowledged a reboot, s.
    #[getter]
    fn reboot(&self, py: Python<'_>) -> Option<f64> {
        self.with(py, |master, _| master.report().reboot).map(seconds)
    }

    /// Mechanical speed from the source that the control mode uses, rpm.
    #[getter]
    fn speed(&self, py: Python<'_>) -> Option<i16> {
        self.with(py, |master, _| Some(master.speed()?.value))
    }

    /// Raw value of a parameter as last received; `None` before.
    fn parameter(&self, py: Python<'_>, number: u16) -> Option<i64> {
        let tables = self.tables();
        let row = tables.row(number)?;
        let received = self.with(py, |master, _| master.parameters().get(number))?;
        Some(row.kind.widen(received.value))
    }

    /// Starts to read every parameter in the background.
    fn read_parameters(&self, py: Python<'_>) {
        self.with(py, |master, _| master.read_parameters());
    }

    /// Number of parameters that are still to be read in the background.
    #[getter]
    fn parameters_to_read(&self, py: Python<'_>) -> usize {
        self.with(py, |master, _| master.parameters_to_read())
    }

    /// Queues a request: "read", "write" or one of the services of PROTOCOL.md by its name. `poll_answer`
    /// returns the answer.
    #[pyo3(signature = (what, number=0, raw=0))]
    fn request(&self, py: Python<'_>, what: &str, number: u16, raw: i64) -> PyResult<()> {
        let request = request(what, number, raw)?;
        self.with(py, |master, _| master.request(request)).map_err(error::refused)
    }

    /// Sets the digital lines: each is an input (`None`), or an output of this level.
    fn set_outputs(
        &self,
        py: Python<'_>,
        dsio1: &Bound<'_, PyAny>,
        dsio2: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let level = |name, line: &Bound<'_, PyAny>| {
            if line.is_none() { Ok(None) } else { error::flag(name, line).map(Some) }
        };
        let (dsio1, dsio2) = (level("dsio1", dsio1)?, level("dsio2", dsio2)?);
        let outputs = DigitalOutputs {
            enable1: dsio1.is_some(),
            value1: dsio1.unwrap_or(false),
            enable2: dsio2.is_some(),
            value2: dsio2.unwrap_or(false),
        };
        self.with(py, |master, _| master.request(Request::DigitalOutputs(outputs))).map_err(error::refused)
    }

    /// Returns the next answer, `None` before it has come: the raw value that a parameter has now, 0 for
    /// other requests.
    fn poll_answer(&self, py: Python<'_>) -> PyResult<Option<i64>> {
        let Some(Answer { request, result }) = self.with(py, |master, _| master.poll_answer()) else {
            return Ok(None);
        };
        let number = match request {
            Request::Read { number } | Request::Write { number, .. } => Some(number),
            Request::Run(service) => Some(service as u16),
            _ => None,
        };
        let tables = self.tables();
        let row = number.and_then(|number| tables.row(number));
        match result {
            Ok(raw) => Ok(Some(row.map_or(raw.into(), |row| row.kind.widen(raw)))),
            Err(error) => Err(job_error(&tables, JobError::Request(request, error))),
        }
    }

    /// Begins a download: "description", "scope" with `count` words, "log" with `count` records from `first`
    /// on.
    #[pyo3(signature = (what, first=0, count=0))]
    fn download(&self, py: Python<'_>, what: &str, first: u32, count: u32) -> PyResult<()> {
        let download = match what {
            "description" => Download::Description,
            "scope" => Download::Scope { words: count },
            _ => Download::Log { first, records: count },
        };
        self.with(py, |master, _| master.download(download)).map_err(error::refused)
    }

    /// Returns the words that have arrived: their place in the download, and their bytes, high byte first.
    fn poll_chunks<'py>(&self, py: Python<'py>) -> Vec<(u32, Bound<'py, PyBytes>)> {
        let chunks = self.with(py, |master, _| {
            std::iter::from_fn(|| master.poll_chunk())
                .map(|chunk| (chunk.offset, chunk.bytes().collect::<Vec<u8>>()))
                .collect::<Vec<_>>()
        });
        chunks.into_iter().map(|(offset, bytes)| (offset, PyBytes::new(py, &bytes))).collect()
    }

    /// Number of words received, and the total; `None` before the length is known, and without a download.
    fn download_progress(&self, py: Python<'_>) -> Option<(u32, u32)> {
        self.with(py, |master, _| master.download_progress())
            .map(|progress| (progress.received, progress.total))
    }

    /// Returns the length of the download in words, once it is complete and all its chunks were taken.
    fn poll_download(&self, py: Python<'_>) -> PyResult<Option<u32>> {
        self.with(py, |master, _| master.poll_download()).transpose().map_err(error::download)
    }

    /// Aborts the download.
    fn abort_download(&self, py: Python<'_>) {
        self.with(py, |master, _| master.abort_download());
    }

    /// Begins to program the drive with an image.
    fn update(&self, py: Python<'_>, image: Vec<u8>) -> PyResult<()> {
        let header = narx_boot::Header::of(&image).map_err(error::image)?;
        let about = Image::new(header.hardware, header.version.into(), &image);
        let begun = match &self.host {
            Host::Bench(session) => session.with(py, |session| session.update(about, image)),
            Host::Free(free) => py.detach(|| {
                let mut free = free.lock().unwrap_or_else(PoisonError::into_inner);
                free.master.update(about).map(|()| free.image = image)
            }),
        };
        begun.map_err(error::refused)
    }

    /// Stage of the update, number of bytes that are done in it, and length of the image; `None` without an
    /// update.
    fn update_progress(&self, py: Python<'_>) -> Option<(&'static str, u32, u32)> {
        let UpdateProgress { stage, done, total } = self.with(py, |master, _| master.update_progress())?;
        Some((stage.label(), done, total))
    }

    /// Returns whether the drive runs the image now and keeps it. Raises the error of the update.
    fn poll_update(&self, py: Python<'_>) -> PyResult<bool> {
        let end = self.with(py, |master, _| master.poll_update());
        end.transpose().map(|end| end.is_some()).map_err(error::update)
    }

    /// Aborts the update.
    fn abort_update(&self, py: Python<'_>) {
        self.with(py, |master, _| master.abort_update());
    }
}

impl Master {
    fn begin_job(&self, py: Python<'_>, job: Job) -> PyResult<()> {
        match &self.host {
            Host::Bench(session) => session.with(py, |session| session.begin(job)),
            Host::Free(_) => self.with(py, |master, _| master.begin(job)),
        }
        .map_err(error::refused)
    }

    /// The error of a job.
    pub(crate) fn job_error(&self, error: JobError) -> PyErr {
        job_error(&self.tables(), error)
    }

    /// Returns whether a job has ended in success.
    fn ended(&self, end: Option<Result<(), JobError>>) -> PyResult<bool> {
        end.transpose().map(|end| end.is_some()).map_err(|error| self.job_error(error))
    }

    /// Advances the time to `now`; it never goes back.
    fn tell(&self, now: f64) {
        if let Host::Free(free) = &self.host {
            let mut free = free.lock().unwrap_or_else(PoisonError::into_inner);
            free.now = free.now.max(microseconds(now));
        }
    }
}

/// Largest set-point of MOTOR_CMD: whole rpm of 16 bits.
const RPM_MAX: i32 = u16::MAX as i32;

fn request(what: &str, number: u16, raw: i64) -> PyResult<Request> {
    // Parameters of every type have 32 bits; the cast keeps them.
    let raw = raw as i32;
    Ok(match what {
        "read" => Request::Read { number },
        "write" => Request::Write { number, raw },
        "restore factory" => Request::RestoreFactory { serial: number },
        _ => error::choice("request", what, &Request::NAMED)?,
    })
}

/// Jobs without arguments, by their names.
const JOBS: [(&str, Job); 2] = [("calibrate hall", Job::CalibrateHall), ("reboot", Job::Reboot)];

/// Settings of a record, as Python passes them.
type Setup = (u32, Given, Given, Given, u8, u8, i32);

/// Converts the error of a job, or of one request. An error about a parameter has the drive's own name and
/// range.
fn job_error(tables: &Tables, error: JobError) -> PyErr {
    if let JobError::Request(_, RequestError::Refused(refusal)) = error {
        return tables.refusal(&refusal);
    }
    match error.kind() {
        ErrorKind::Start => error::start(error),
        ErrorKind::Refused => error::refused(error),
        ErrorKind::NoAnswer => error::no_answer(error),
        ErrorKind::Parameter | ErrorKind::Range => error::parameter(error),
    }
}

/// Returns the names of the set bits.
pub(crate) fn names(faults: FaultWord) -> impl Iterator<Item = String> {
    faults.iter_names().map(|(name, _)| name.to_ascii_lowercase()).collect::<Vec<_>>().into_iter()
}

fn microseconds(seconds: f64) -> u64 {
    (seconds * 1e6).round() as u64
}

fn seconds(microseconds: u64) -> f64 {
    microseconds as f64 / 1e6
}

/// Converts a speed to whole rpm in the range of MOTOR_CMD.
pub(crate) fn rpm(rpm: Given) -> PyResult<i32> {
    error::whole("rpm", rpm, "", -RPM_MAX, RPM_MAX)
}
