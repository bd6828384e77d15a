//! The bench: the real drive and node around the plant, on a CAN bus, with a master's place on it.
//!
//! ```text
//!  host frames <--> bus <--> Device --PwmCommand--> Plant
//!                            |    ^                   |
//!      flash <--Request------+    +------Samples------+
//!            ---Report------->
//! ```
//!
//! TX-Drivers may stand on the same bus and watch the same shaft ([`Bench::add_tx_driver`]), and a second
//! drive with a motor of its own may stand on that bus ([`Bench::move_beside`]).
//!
//! One call of [`Bench::step`] is one control tick. Same configuration, same frames, same bits.

#[cfg(feature = "tx-drivers")]
mod beside;
mod host;
mod node;
mod scope_memory;
mod seen;
mod signals;
#[cfg(feature = "update")]
mod slots;
#[cfg(feature = "tx-drivers")]
mod tx_drivers;

pub(crate) use node::BenchNode;
pub use signals::SIGNALS;

use crate::can::{Attachment, Bus, BusStatistics, NodeIndex};
use crate::chip::Chip;
#[cfg(feature = "flash")]
use crate::flash::{Flash, Sparse};
#[cfg(feature = "update")]
use crate::internal_flash::InternalFlash;
use crate::plant::{Plant, PlantConfig};
use crate::recording::RecordingBuffer;
#[cfg(feature = "tx-drivers")]
use crate::tx_driver::TxDrivers;
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use narx_core::device::Device;
use narx_core::dictionary::Parameters;
use narx_core::motor::drive::{BEHAVIOUR_VERSION, LAYOUT_VERSION};
use narx_core::motor::machine::event::Health;
use narx_core::motor::{PwmCommand, Status};
use narx_core::node::{Action, Identity, Node};
use narx_core::recording::{Header, Kind, Recorder};
use narx_core::storage::{FlashReply, FlashTask};
use scope_memory::ScopeMemory;
use seen::Seen;
use signals::Kept;
#[cfg(feature = "update")]
use slots::Slots;

/// Bit rate of the drive's bus (Table 2).
pub const BITRATE: u32 = 500_000;
/// Identity that the simulated board reports.
pub const IDENTITY: Identity = Identity {
    build_number: 1,
    source_modified: false,
    build_date: 20_261_120,
    hardware_release: 1,
    software_release: 0x0001,
};

/// The board reads its slow inputs this often, ms.
const INPUTS_MS: u64 = 10;

/// Drive, host, a listener and another node; where there are TX-Drivers, as many as have node-ids. A second
/// drive takes one of their places.
const PLACES: usize = if cfg!(feature = "tx-drivers") { 4 + 127 } else { 4 };
/// Frames that wait at each place on the bus.
const QUEUE: usize = 64;
/// Frames that the drive's controller holds. What waits there can be overtaken by nothing.
const MAILBOXES: usize = 3;
/// Frames of a download in the drive's controller: one on the bus, and one to follow it without a gap.
const BULK: usize = 2;

/// Configuration of a bench.
#[derive(Clone, Debug)]
pub struct BenchConfig {
    /// The physical side.
    pub plant: PlantConfig,
    /// Parameters that are stored on the drive's flash.
    pub parameters: Parameters,
    /// Goes into recordings; cut at 255 bytes.
    pub label: String,
    /// Keep a row per tick for [`Bench::trace`].
    pub trace: bool,
}

/// A drive on a bench. A copy is the whole bench as it stands, flash and recording included.
#[derive(Clone, Debug)]
pub struct Bench {
    plant: Plant,
    device: Device<ScopeMemory, BenchNode>,
    chip: Chip,
    /// While the flash is busy: time at which it has finished, ns, and its report then.
    report: Option<(u64, FlashReply)>,
    #[cfg(feature = "update")]
    slots: Slots,
    /// There is a bootloader.
    #[cfg(feature = "update")]
    programmable: bool,
    bus: Bus<PLACES, QUEUE>,
    /// Places on the bus: the drive's, the host's, a listener's and another node's.
    own: NodeIndex,
    host: NodeIndex,
    monitor: NodeIndex,
    other: NodeIndex,
    /// Ticks from one slow input to the next.
    inputs_every: u64,
    tick_rate: u64,
    /// Mechanical rpm of the last bit of an electrical speed.
    rpm_per_bit: f64,
    kept: Option<Box<Kept>>,
    command: PwmCommand,
    hall: u8,
    /// Record from the next boot on.
    record: bool,
    recorder: Option<Recorder<RecordingBuffer>>,
    /// Write down what the node is told and asked, from the next boot on.
    #[cfg(feature = "transcripts")]
    transcribe: bool,
    label: String,
    #[cfg(feature = "tx-drivers")]
    tx_drivers: TxDrivers,
}

impl Bench {
    /// Powers up a drive on the plant; the configuration's parameters stand on its flash of 256 Mbit, the log
    /// is empty.
    pub fn new(config: &BenchConfig) -> Self {
        Self::with_chip(config, Chip::new(&config.parameters))
    }

    /// Powers up a drive on the plant with a flash from somewhere else: its content counts, and the
    /// configuration's parameters do not.
    #[cfg(feature = "flash")]
    pub fn with_flash(config: &BenchConfig, flash: Flash<Sparse>) -> Self {
        Self::with_chip(config, Chip::with_flash(flash))
    }

    fn with_chip(config: &BenchConfig, chip: Chip) -> Self {
        let board = config.plant.board;
        let mut bus = Bus::new(BITRATE);
        let [own, host, monitor, other] = bus.attach_first();
        bus.set_attachment(monitor, Attachment::ListenOnly);
        bus.set_attachment(other, Attachment::Detached);
        let parameters = &config.parameters;
        let node = BenchNode::new(Node::with_parameters(IDENTITY, board, parameters.clone()));
        let mut bench = Self {
            plant: Plant::new(&config.plant),
            device: Device::power_up(node, &board, parameters, ScopeMemory::new()),
            chip,
            report: None,
            #[cfg(feature = "update")]
            slots: Slots::new(&IDENTITY),
            #[cfg(feature = "update")]
            programmable: true,
            bus,
            own,
            host,
            monitor,
            other,
            inputs_every: (u64::from(board.tick_rate) * INPUTS_MS / 1000).max(1),
            tick_rate: board.tick_rate.max(1).into(),
            rpm_per_bit: 60.0 / 65_536.0 / f64::from(config.plant.motor.pole_pairs),
            kept: config.trace.then(|| Box::new(Kept::all())),
            command: PwmCommand::default(),
            hall: 0,
            record: true,
            recorder: None,
            #[cfg(feature = "transcripts")]
            transcribe: false,
            label: config.label.chars().take(60).collect(),
            #[cfg(feature = "tx-drivers")]
            tx_drivers: TxDrivers::new(config.plant.seed),
        };
        bench.boot();
        bench
    }

    /// Power-up or reboot of the drive: what is not stored is lost.
    fn boot(&mut self) {
        let board = *self.node().board();
        let Some((FlashReply::Opened(opened), _)) = self.chip.execute(FlashTask::Open) else { return };
        self.report = None;
        #[cfg(feature = "update")]
        self.slots.boot();
        let parameters = opened.parameters.clone();
        let mut node = BenchNode::new(Node::with_parameters(IDENTITY, board, parameters.clone()));
        #[cfg(feature = "transcripts")]
        if self.transcribe {
            node.begin_transcript(IDENTITY, &self.label);
        }
        node.attach_storage(&opened);
        #[cfg(feature = "update")]
        if self.programmable {
            self.slots.attach(&mut node);
        }
        self.device = Device::power_up(node, &board, &parameters, ScopeMemory::new());
        self.recorder = self.record.then(|| self.recorder()).flatten();
    }

    /// A recording that begins with the drive as it is now.
    fn recorder(&self) -> Option<Recorder<RecordingBuffer>> {
        let board = self.node().board();
        let header = Header {
            kind: Kind::Drive,
            behaviour_version: BEHAVIOUR_VERSION,
            layout_version: LAYOUT_VERSION,
            tick_rate: board.tick_rate,
            label: &self.label,
        };
        let mut state = Vec::new();
        self.device.drive().write_state(&mut |byte| {
            state.push(byte);
            true
        });
        Recorder::new(RecordingBuffer::default(), &header, &state).ok()
    }

    /// Returns this bench without a recorder: for the many runs of which only the outcome counts.
    /// [`Bench::recording`] is then empty and [`Bench::digest`] 0.
    #[must_use]
    pub fn without_recording(self) -> Self {
        Self { record: false, recorder: None, ..self }
    }

    /// Returns this bench with a drive that has no bootloader: it is powered up anew, and cannot be
    /// programmed over CAN.
    #[cfg(feature = "update")]
    #[must_use]
    pub fn without_programming(mut self) -> Self {
        self.programmable = false;
        self.boot();
        self
    }

    /// Returns this bench, powered up anew, with a transcript of its node's inputs and queries:
    /// [`Bench::transcript`].
    #[cfg(feature = "transcripts")]
    #[must_use]
    pub fn with_transcript(mut self) -> Self {
        self.transcribe = true;
        self.boot();
        self
    }

    /// Transcript of the node's inputs and queries since it last booted, to be [run
    /// again](narx_core::recording::transcript); empty without [`Bench::with_transcript`].
    #[cfg(feature = "transcripts")]
    pub fn transcript(&self) -> Vec<u8> {
        self.device.node().transcript()
    }

    /// Tells the node what its shell would have found out about store and self-tests.
    pub fn set_health(&mut self, health: Health) {
        self.device.node_mut().handle_health(health);
    }

    /// One control tick.
    pub fn step(&mut self) {
        let samples = self.plant.sample();
        let command = match &mut self.recorder {
            None => self.device.step(&samples, &mut ()),
            Some(recorder) => {
                let mut seen = Seen::default();
                let command = self.device.step(&samples, &mut seen);
                let Seen { event, status } = seen;
                if recorder.record(event.as_ref(), &samples, &command, status.as_ref()).is_err() {
                    self.recorder = None;
                }
                command
            }
        };
        self.plant.finish_period(&command);
        self.run_background();
        (self.command, self.hall) = (command, samples.hall);
        self.keep();
    }

    /// Does the work of the firmware's background loop, once a tick.
    fn run_background(&mut self) {
        let now = self.plant.tick();
        let now_ns = self.now_ns();
        #[cfg(feature = "tx-drivers")]
        self.run_tx_drivers(now_ns);
        self.bus.advance(now_ns);
        let state = self.bus.state(self.own);
        if state.is_off() {
            self.bus.discard(self.own);
        }
        self.device.node_mut().handle_bus_state(state);
        while let Some(received) = self.bus.receive(self.own) {
            self.device.node_mut().handle_frame(&received.frame);
        }
        if now.is_multiple_of(self.inputs_every) {
            let inputs = self.plant.slow_inputs();
            self.device.node_mut().handle_inputs(inputs);
        }
        self.device.run(now);
        let node = self.device.node_mut();
        // The controller takes what fits; the rest waits in the node.
        while self.bus.queued(self.own) < MAILBOXES
            && let Some(frame) = node.poll_frame()
        {
            // Room was just seen.
            let _ = self.bus.send(self.own, frame, now_ns);
        }
        while self.bus.queued(self.own) < BULK
            && let Some(frame) = node.poll_bulk_frame()
        {
            // Room was just seen.
            let _ = self.bus.send(self.own, frame, now_ns);
        }
        self.serve_flash(now_ns);
        let node = self.device.node_mut();
        #[cfg(feature = "update")]
        self.slots.serve(node, now_ns);
        self.plant.set_outputs(node.outputs());
        if let Some(Action::Reboot) = node.poll_action() {
            self.boot();
        }
    }

    /// The node's requests to the flash. What one does happens at once, and is told when the flash would be
    /// ready.
    fn serve_flash(&mut self, now_ns: u64) {
        if self.report.as_ref().is_some_and(|(due, _)| *due <= now_ns)
            && let Some((_, report)) = self.report.take()
        {
            self.device.node_mut().handle_storage(report);
        }
        if self.report.is_none()
            && let Some(request) = self.device.node_mut().poll_storage()
        {
            self.report = self.chip.execute(request).map(|(report, busy)| (now_ns + busy, report));
        }
    }

    /// The drive's flash, to look at and to break.
    #[cfg(feature = "flash")]
    pub const fn flash(&mut self) -> &mut Flash<Sparse> {
        self.chip.flash()
    }

    /// The flash with the drive's program and the slot for another, to look at and to break.
    #[cfg(feature = "update")]
    pub fn program_flash(&mut self) -> &mut InternalFlash<Sparse> {
        self.slots.flash()
    }

    /// Takes the flash out of the drive, to put it into another one.
    #[cfg(feature = "flash")]
    pub fn into_flash(self) -> Flash<Sparse> {
        self.chip.into_flash()
    }

    /// Time since power-up, s.
    pub fn time(&self) -> f64 {
        self.plant.observe().time
    }

    /// Time since power-up, ns, rounded down.
    pub fn now_ns(&self) -> u64 {
        const SECOND: u64 = 1_000_000_000;
        let (seconds, ticks) = (self.plant.tick() / self.tick_rate, self.plant.tick() % self.tick_rate);
        seconds * SECOND + ticks * SECOND / self.tick_rate
    }

    /// The physical side, to look at.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// The physical side, to change: load, supply, faults.
    pub fn plant_mut(&mut self) -> &mut Plant {
        &mut self.plant
    }

    /// The device.
    pub fn node(&self) -> &Node {
        self.device.node()
    }

    /// The last report of the control tick.
    pub fn status(&self) -> &Status {
        self.node().status()
    }

    /// Returns the command that the drive gave in the last tick.
    pub const fn command(&self) -> &PwmCommand {
        &self.command
    }

    /// Returns the counts of frames and errors on the bus, and its busy time.
    pub fn bus_statistics(&self) -> BusStatistics {
        self.bus.statistics()
    }

    /// Recording of the drive since it last booted.
    pub fn recording(&self) -> Vec<u8> {
        let finished = self.recorder.clone().and_then(|recorder| recorder.finish().ok());
        finished.unwrap_or_default().0
    }

    /// Forgets what was recorded, and begins anew with the drive as it is now. The next restart ends it, if
    /// the bench was made [without a recording](Self::without_recording).
    pub fn begin_recording(&mut self) {
        self.recorder = self.recorder();
    }

    /// The recording that [`Self::begin_recording`] began; empty if the drive has restarted since then.
    pub fn end_recording(&mut self) -> Vec<u8> {
        let recording = self.recording();
        self.recorder = None;
        recording
    }

    /// Digest of the drive's outputs since it last booted.
    pub fn digest(&self) -> u64 {
        self.recorder.as_ref().map_or(0, Recorder::digest)
    }
}
