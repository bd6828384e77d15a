//! Bus master: commands one drive, sends requests to it, and keeps its answers and broadcasts. A pure state
//! machine without a clock or a bus of its own, for another electronic board, a notebook or a web page.
//!
//! ```text
//!                                      +--------+ <-- start, stop, set_speed, shut_down
//!  frames, time ---- handle_frame ---> | Master | <-- request, begin, download
//!  frames <--- poll_frame <-- time --- |        | --> poll_answer, poll_job, poll_chunk, poll_download
//!                                      +--------+ --> report, measurements, parameters: what was received, and when
//! ```
//!
//! Time is given in microseconds from any beginning and never runs back. Call `handle_frame` for every frame
//! that arrives and `poll_frame` until it has nothing left, at [`Master::next_poll`] at the latest. One call
//! answers one frame at most.
//!
//! Messages are sent by priority: set-point and request word, then requests of the caller in their order,
//! then those of the jobs, then the download, then reading of parameters in the background. One message is
//! under way at a time, so that each answer belongs to its message. An answer that arrives after the
//! time-out, or twice, may be taken for the answer to the next message on the same parameter.
//!
//! [`eddycan`] is the master of a TX-Driver.

mod assembly;
mod commands;
mod described;
mod download;
mod draft;
pub mod eddycan;
mod error;
mod exchange;
mod job;
mod limits;
mod markup;
mod measurements;
mod missing;
mod parameters;
mod report;
mod requests;
mod rows;
mod stream;
#[cfg(feature = "update")]
mod update;
mod waiting;

pub use described::{DescriptionError, DescriptionReader, Reason};
pub use download::{Chunk, Download, Progress};
pub use error::{DownloadError, NotTaken, Refusal, RequestError};
pub use job::{ErrorKind, Job, JobError, ScopeSetup};
pub use limits::{SpeedError, SpeedLimit, SpeedLimits};
pub use measurements::Measurements;
pub use parameters::ParameterMirror;
pub use report::{BuildInfo, CriticalFault, DescriptionInfo, DeviceInfo, Received, Report};
pub use requests::{Answer, Request, Service};
pub use rows::{Described, DescribedCategory, DescribedField, DescribedParameter, DescribedSignal};
#[cfg(feature = "update")]
pub use update::{Image, PACE, UpdateError, UpdateProgress, UpdateStage};

use crate::bus::Frame;
use crate::bus::narmotion::{Addresses, FromDrive, MotorMode, ParameterStatus, ToDrive};
use crate::dictionary::number;
use crate::motor::guard::fault::FaultWord;
use crate::motor::machine::state::State;
use commands::Commands;
use download::Transfer;
use exchange::{Exchange, Owner, Step};
use job::{Command, Jobs, View};
use parameters::Reader;
use requests::{Requests, Todo};

/// Shortest period and time-out, microseconds: three frames of the longest kind.
const SHORTEST: u64 = 1000;
/// Period in which a job looks at the drive, microseconds.
const LOOK: u64 = 5000;

/// Configuration of a master. Times are in microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Config {
    /// Addresses of the drive and of the master.
    pub addresses: Addresses,
    /// Period of the set-points, at least 1000; default 50 000 (Figure 9).
    pub setpoint_period: u64,
    /// Listens only (Figure 9): transmits nothing, commands have no effect, requests are not taken.
    pub silent: bool,
    /// Reads every parameter when the first frame of the drive is received, after it was lost, and after an
    /// action that changes many of them.
    pub read_parameters: bool,
    /// Longest time until an answer, at least 1000; default 100 000.
    pub timeout: u64,
    /// Number of times that a message is sent before it counts as not answered, at least 1; default 3.
    pub attempts: u8,
    /// Silence after which the drive counts as lost; default 500 000. At least the time-out, and at least
    /// three of the drive's broadcast periods where parameter 111 is known.
    pub lost_after: u64,
}

impl Default for Config {
    /// The values of Figure 9, at the factory addresses.
    fn default() -> Self {
        Self {
            addresses: Addresses::FACTORY,
            setpoint_period: 50_000,
            silent: false,
            read_parameters: true,
            timeout: 100_000,
            attempts: 3,
            lost_after: 500_000,
        }
    }
}

/// The master of one drive.
#[derive(Clone, Debug)]
pub struct Master {
    config: Config,
    commands: Commands,
    requests: Requests,
    /// The job of the motor, and that of the scope or the log.
    jobs: Jobs,
    records: Jobs,
    transfer: Transfer,
    reader: Reader,
    exchange: Exchange,
    parameters: ParameterMirror,
    report: Report,
    measurements: Measurements,
    #[cfg(feature = "update")]
    update: update::Update,
}

impl Master {
    /// Makes a master without a command yet: it sends set-points of 0, which keep measurements coming, but
    /// neither stop a motor nor acknowledge a fault. A drive whose motor another master has started gets
    /// none: they would keep the motor turning after that master is gone.
    pub fn new(config: Config) -> Self {
        let timeout = config.timeout.max(SHORTEST);
        let setpoint_period = config.setpoint_period.max(SHORTEST);
        let lost_after = config.lost_after.max(timeout);
        Self {
            config: Config { setpoint_period, timeout, lost_after, ..config },
            commands: Commands::default(),
            requests: Requests::default(),
            jobs: Jobs::default(),
            records: Jobs::default(),
            transfer: Transfer::default(),
            reader: Reader::default(),
            exchange: Exchange::default(),
            parameters: ParameterMirror::default(),
            report: Report::default(),
            measurements: Measurements::default(),
            #[cfg(feature = "update")]
            update: update::Update::default(),
        }
    }

    /// Configuration in force: the one given to [`Master::new`], within the bounds of [`Config`].
    pub const fn config(&self) -> &Config {
        &self.config
    }

    /// The last messages of the drive about itself.
    pub const fn report(&self) -> &Report {
        &self.report
    }

    /// The drive's measurements.
    pub const fn measurements(&self) -> &Measurements {
        &self.measurements
    }

    /// The drive's parameters, as last received.
    pub const fn parameters(&self) -> &ParameterMirror {
        &self.parameters
    }

    /// The exact state, or `None` while it is not known. The status word cannot tell some states from each
    /// other (Table 8), so parameter 261 is read whenever that word is received.
    pub fn state(&self) -> Option<State> {
        let exact = self.parameters.get(number::DRIVE_STATE).map(|received| received.value);
        self.report.state(exact)
    }

    /// Mechanical speed from the source that the drive's control mode uses, rpm, negative in reverse:
    /// [`Measurements::speed`].
    pub fn speed(&self) -> Option<Received<i16>> {
        self.measurements.speed(self.report.status.map(|status| status.value.control))
    }

    /// Returns whether a frame of the drive was received lately.
    pub fn is_connected(&self, now: u64) -> bool {
        let period = self.parameters.get(number::AUTOSEND_PERIOD).map_or(0, |received| received.value);
        let lost_after = self.config.lost_after.max(u64::from(period.unsigned_abs()) * 3000);
        self.report.last.is_some_and(|last| now.saturating_sub(last) < lost_after)
    }
}

/// Commands for the motor, repeated every period.
impl Master {
    /// Returns the set-points that the drive accepts unchanged; `None` before the parameters of the enabled
    /// mode, among [`SpeedLimits::PARAMETERS`], were received.
    pub fn speed_limits(&self) -> Option<SpeedLimits> {
        SpeedLimits::of(|number| self.parameters.get(number).map(|received| received.value))
    }

    /// Checks a set-point, rpm, negative in reverse, against the drive's limits, or against the range of
    /// MOTOR_CMD before they were received. Call it before [`Master::start`] and [`Master::set_speed`]. The
    /// drive clamps a set-point outside its limits; [`Report::accepted_speed`] shows the result.
    ///
    /// # Errors
    /// The drive would clamp it.
    pub fn check_speed(&self, rpm: i32) -> Result<(), SpeedError> {
        self.speed_limits().unwrap_or(SpeedLimits::WIRE).check(rpm)
    }

    /// Requests a start at a speed, mechanical rpm, negative in reverse (Drive or Reverse of the request
    /// word). A drive accepts a start only if it received Standby since it last stopped: call
    /// [`Master::stop`] first, or begin a [`Job::Start`], which does. Ends a job, but a
    /// [`Job::AwaitStart`].
    pub fn start(&mut self, rpm: i32) {
        self.jobs.start_requested();
        self.turn(rpm);
    }

    fn turn(&mut self, rpm: i32) {
        let mode = if rpm < 0 { MotorMode::Reverse } else { MotorMode::Drive };
        self.commands.set_speed(rpm.unsigned_abs().min(u32::from(u16::MAX)) as u16);
        self.commands.request(mode);
    }

    /// Requests another speed in the same direction, rpm. The drive answers with the speed that it accepts:
    /// [`Report::accepted_speed`].
    pub fn set_speed(&mut self, rpm: u16) {
        match self.jobs.pending_speed() {
            Some(pending) => *pending = pending.signum() * i32::from(rpm),
            None => self.commands.set_speed(rpm),
        }
    }

    /// Requests Standby, which also acknowledges a fault. Ends a job.
    pub fn stop(&mut self) {
        self.jobs.abort();
        self.commands.request(MotorMode::Standby);
    }

    /// Requests a shutdown (motor mode 3): fault bit 28. Ends a job.
    pub fn shut_down(&mut self) {
        self.jobs.abort();
        self.commands.request(MotorMode::Fault);
    }

    /// Motor mode last requested; `None` before the first command.
    pub const fn requested(&self) -> Option<MotorMode> {
        self.commands.mode()
    }

    /// Magnitude of the set-point, rpm.
    pub const fn setpoint(&self) -> u16 {
        self.commands.speed()
    }
}

/// Jobs: at a time one of the motor, and one of the scope or the log.
impl Master {
    /// Begins a job; one of the same kind that is under way ends without a result.
    ///
    /// # Errors
    /// A silent master.
    pub fn begin(&mut self, job: Job) -> Result<(), NotTaken> {
        if self.config.silent {
            return Err(NotTaken::Silent);
        }
        if job.is_record() { &mut self.records } else { &mut self.jobs }.begin(job);
        Ok(())
    }

    /// Result of the motor's job, once it has ended.
    pub fn poll_job(&mut self) -> Option<Result<(), JobError>> {
        self.jobs.poll_end()
    }

    /// Result of the job of the scope or the log, once it has ended.
    pub fn poll_record(&mut self) -> Option<Result<(), JobError>> {
        self.records.poll_end()
    }

    /// Ends the job of the scope or the log; its result is [`JobError::Aborted`]. What the drive has begun
    /// goes on.
    pub fn abort_record(&mut self) {
        self.records.abort();
    }

    /// Returns whether a job is under way.
    pub const fn is_at_work(&self) -> bool {
        self.jobs.is_running() || self.records.is_running()
    }

    /// Returns whether a start waits until the drive accepts it.
    pub fn is_start_pending(&mut self) -> bool {
        self.jobs.pending_speed().is_some()
    }

    /// The drive as a job sees it.
    fn view(&self, now: u64) -> View {
        View {
            state: self.state(),
            mode: self.report.status.map(|status| status.value.mode),
            requested: matches!(self.requested(), Some(MotorMode::Drive | MotorMode::Reverse)),
            faults: self.report.faults.map_or_else(FaultWord::empty, |faults| faults.value),
            logging: self.report.status.map(|status| status.value.logging),
            connected: self.is_connected(now),
            period: self.config.setpoint_period,
        }
    }

    /// Lets the jobs look at the drive, and gives their command.
    fn work(&mut self, now: u64) {
        if !self.is_at_work() {
            return;
        }
        let view = self.view(now);
        // A job of the scope or the log gives no command.
        self.records.look(&view, now);
        match self.jobs.look(&view, now) {
            Some(Command::Standby) => self.commands.request(MotorMode::Standby),
            Some(Command::Turn(rpm)) => self.turn(rpm),
            None => {}
        }
    }
}

/// Requests, each answered once, and one download at a time.
impl Master {
    /// Queues a request to the drive. Answers come in the order of the requests.
    ///
    /// # Errors
    /// A silent master, or eight requests whose answers were not taken yet.
    pub fn request(&mut self, request: Request) -> Result<(), NotTaken> {
        if self.config.silent {
            return Err(NotTaken::Silent);
        }
        self.requests.push(request)
    }

    /// The next answer.
    pub fn poll_answer(&mut self) -> Option<Answer> {
        self.requests.pop()
    }

    /// Begins a download.
    ///
    /// # Errors
    /// A silent master, or a download whose end was not taken yet.
    pub fn download(&mut self, what: Download) -> Result<(), NotTaken> {
        if self.config.silent {
            return Err(NotTaken::Silent);
        }
        self.transfer.begin(what, self.config.attempts)
    }

    /// The next words of the download. Words may come more than once, each time the same.
    pub fn poll_chunk(&mut self) -> Option<Chunk> {
        self.transfer.pop()
    }

    /// Progress of the download; `None` before its length is known, and without a download.
    pub fn download_progress(&self) -> Option<Progress> {
        self.transfer.progress()
    }

    /// Result of the download, once all its chunks were taken: its length in words, or the error.
    pub fn poll_download(&mut self) -> Option<Result<u32, DownloadError>> {
        self.transfer.poll_end()
    }

    /// Aborts the download; its result is [`DownloadError::Aborted`].
    pub fn abort_download(&mut self) {
        self.transfer.abort();
    }

    /// Begins to program the drive with this image, whose bytes are passed to [`Master::poll_update_frame`].
    /// The drive must be in Standby, or in Fault at standstill, and refuses a start until the update is done.
    ///
    /// # Errors
    /// A silent master, or an update whose end was not taken yet.
    #[cfg(feature = "update")]
    pub fn update(&mut self, image: Image) -> Result<(), NotTaken> {
        if self.config.silent {
            return Err(NotTaken::Silent);
        }
        self.update.begin(image, self.config.attempts, self.config.timeout)
    }

    /// Progress of the update; `None` without one.
    #[cfg(feature = "update")]
    pub fn update_progress(&self) -> Option<UpdateProgress> {
        self.update.progress()
    }

    /// Result of the update: the drive runs the image and keeps it, or the error. After an error the previous
    /// image still runs.
    #[cfg(feature = "update")]
    pub fn poll_update(&mut self) -> Option<Result<(), UpdateError>> {
        self.update.poll_end()
    }

    /// Aborts the update; its result is [`UpdateError::Aborted`]. An image that is swapped in already is not
    /// confirmed, so the drive goes back to the previous one.
    #[cfg(feature = "update")]
    pub const fn abort_update(&mut self) {
        self.update.abort();
    }

    /// Reads every parameter anew in the background.
    pub fn read_parameters(&mut self) {
        self.reader.read_all();
    }

    /// Parameters that are still to be read in the background.
    pub const fn parameters_to_read(&self) -> usize {
        self.reader.left()
    }
}

/// The bus.
impl Master {
    /// Takes a frame that arrived at `now`. Only messages of this drive to this master are used.
    pub fn handle_frame(&mut self, frame: &Frame, now: u64) {
        let Config { addresses, .. } = self.config;
        let message = match FromDrive::decode(frame) {
            Ok((id, message)) if id.source == addresses.drive && id.destination == addresses.master => {
                message
            }
            _ => return,
        };
        if !self.is_connected(now) {
            self.forget_parameters();
        }
        self.report.note(&message, now);
        self.measurements.note(&message, now);
        match message {
            FromDrive::Status(_) => self.reader.read_state(),
            FromDrive::Parameter { number, value, status } if status != ParameterStatus::UnknownNumber => {
                self.parameters.note(number, value, now);
            }
            FromDrive::Reboot => self.forget_parameters(),
            _ => {}
        }
        self.transfer.take(&message, now);
        #[cfg(feature = "update")]
        self.update.take(&message, now);
        if let Some(owner) = self.exchange.answer(&message) {
            self.finish(owner, Some(&message), now);
        }
    }

    /// The next frame that is due at `now`.
    pub fn poll_frame(&mut self, now: u64) -> Option<Frame> {
        if self.config.silent {
            return None;
        }
        self.work(now);
        let message = self.commands.poll(now, self.config.setpoint_period, self.report.drives());
        let message = message.or_else(|| self.poll_message(now));
        #[cfg(feature = "update")]
        let message = message.or_else(|| self.update.next(now));
        Some(message?.encode(self.config.addresses))
    }

    /// Returns the next block of the update that is due at `now`, from the bytes of its image. Call it when
    /// [`Master::poll_frame`] has nothing left.
    #[cfg(feature = "update")]
    pub fn poll_update_frame(&mut self, now: u64, image: &[u8]) -> Option<Frame> {
        let message = self.update.next_block(now, image)?;
        Some(message.encode(self.config.addresses))
    }

    /// Latest time of the next poll, if no frame arrives and nothing is requested until then; `now` when
    /// something is due.
    pub fn next_poll(&self, now: u64) -> u64 {
        if self.config.silent {
            return u64::MAX;
        }
        let wanted = self.requests.is_waiting() || self.transfer.is_sending();
        let next = match self.exchange.deadline(self.config.timeout) {
            Some(deadline) => deadline,
            None if wanted => now,
            None if self.is_connected(now) => self.reader.due(),
            None => u64::MAX,
        };
        #[cfg(feature = "update")]
        let next = next.min(self.update.due());
        let next = if self.is_at_work() { next.min(now.saturating_add(LOOK)) } else { next };
        next.min(self.transfer.deadline()).min(self.commands.due(self.report.drives())).max(now)
    }

    /// Returns the next message besides commands; a repetition of the message under way comes first.
    fn poll_message(&mut self, now: u64) -> Option<ToDrive> {
        self.transfer.poll(now);
        match self.exchange.poll(now, self.config.timeout) {
            Step::Send(message) => return Some(message),
            Step::Wait => return None,
            Step::Expired(owner) => self.finish(owner, None, now),
            Step::Idle => {}
        }
        let (owner, todo) = self.next_todo(now)?;
        match todo {
            Todo::Tell(message) => Some(message),
            Todo::Ask(message) => {
                self.exchange.begin(message, owner, self.config.attempts, now);
                Some(message)
            }
        }
    }

    fn next_todo(&mut self, now: u64) -> Option<(Owner, Todo)> {
        if let Some(todo) = self.requests.next() {
            return Some((Owner::Request, todo));
        }
        if let Some(todo) = self.jobs.next() {
            return Some((Owner::Job, todo));
        }
        if let Some(todo) = self.records.next() {
            return Some((Owner::Record, todo));
        }
        if let Some(todo) = self.transfer.next(now) {
            return Some((Owner::Download, todo));
        }
        // Only a connected drive is read in the background.
        if !self.is_connected(now) {
            return None;
        }
        let number = self.reader.next(now)?;
        Some((Owner::Reader, Todo::Ask(ToDrive::RequestParameter { number })))
    }

    /// Passes the answer to the message's originator; `None` if none came.
    fn finish(&mut self, owner: Owner, answer: Option<&FromDrive>, now: u64) {
        match owner {
            Owner::Request => {
                if self.requests.finish(answer) {
                    self.forget_parameters();
                }
            }
            Owner::Job => {
                let view = self.view(now);
                self.jobs.finish(answer, &view, now);
            }
            Owner::Record => {
                let view = self.view(now);
                self.records.finish(answer, &view, now);
            }
            Owner::Download => self.transfer.finish(answer, now),
            Owner::Reader => self.reader.finish(),
        }
    }

    /// Forgets the parameters, which may have changed, and reads them anew if so configured.
    fn forget_parameters(&mut self) {
        self.parameters.forget();
        if self.config.read_parameters && !self.config.silent {
            self.reader.read_all();
        }
    }
}
