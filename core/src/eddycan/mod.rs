//! The TX-Driver: an eddy-current displacement sensor's driver with one or two channels and an incremental
//! encoder, as a node of an eddyCAN network. A pure state machine without a clock, a bus or a memory of its
//! own.
//!
//! ```text
//!  frames ------ handle_frame --> +----------+ -- poll_frame --> frames
//!  samples ---- handle_sample --> |          | ----- outputs --> switching outputs
//!  controller handle_bus_state -> | TxDriver | -- poll_store --> configuration to store
//!  memory -------- handle_store > |          | -- take_reset --> restart the device
//!  time ----------------- poll -> +----------+
//! ```
//!
//! Call the `handle_*` as things happen, then `poll` with the time, then each `poll_*` until it has nothing
//! left. A shell that has been told to restart makes a new one from the stored configuration.

mod comparator;
mod configuration;
mod encoder;
mod errors;
mod filter;
mod heartbeat;
mod nmt;
mod objects;
mod outbox;
mod pdo;
mod sdo;
mod sensing;
mod store;

pub use comparator::MeasuringRange;
pub use configuration::{Configuration, EncoderSetup, InvalidConfiguration, UpdateTime};
pub use objects::{Access, Entry, Kind, OBJECTS, Object, STORED};
pub use sensing::Sample;

use crate::bus::eddycan::{
    Bitrate, Channels, DecodeError, ErrorCode, Layout, NmtState, NodeId, PdoKind, ToNode,
};
use crate::bus::{BusState, ErrorState, Frame};
use heartbeat::Heartbeat;
use outbox::Outbox;
use pdo::Timer;
use sensing::Sensing;
use serde::{Deserialize, Serialize};
use store::Store;

/// Hardware and firmware of a driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Variant {
    /// Sensors of the driver.
    pub channels: Channels,
    /// Measuring ranges of the sensors; with one channel the second is ignored.
    pub ranges: [MeasuringRange; 2],
    /// Samples a second that the shell takes, Hz.
    pub sample_rate: u32,
    /// Release of the firmware, major in the high byte (2100h).
    pub firmware: u16,
}

/// The device.
#[derive(Clone, Debug, PartialEq)]
pub struct TxDriver {
    variant: Variant,
    configuration: Configuration,
    /// Node-id in force since the restart; the stored one may differ.
    node: NodeId,
    bitrate: Bitrate,
    state: NmtState,
    /// The last time that was passed in, microseconds.
    now: u64,
    sensing: Sensing,
    timer: Timer,
    heartbeat: Heartbeat,
    outbox: Outbox,
    store: Store,
    bus: BusState,
    restart: Restart,
}

/// Pending restart of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Restart {
    No,
    /// As soon as the configuration is stored, at the latest at this time.
    By(u64),
    /// The shell has been told.
    Told,
}

impl Restart {
    /// Restart within a second: a memory that does not answer must not prevent it.
    const fn within_a_second(now: u64) -> Self {
        Self::By(now.saturating_add(1_000_000))
    }
}

impl TxDriver {
    /// A device at power-up, with the configuration that was stored. The boot-up message is the first that it
    /// sends.
    pub fn new(variant: Variant, configuration: Configuration) -> Self {
        let state = if configuration.autostart() { NmtState::Operational } else { NmtState::PreOperational };
        Self {
            variant,
            configuration,
            node: configuration.node(),
            bitrate: configuration.bitrate(),
            state,
            now: 0,
            sensing: Sensing::new(&variant, &configuration),
            timer: Timer::default(),
            heartbeat: Heartbeat::default(),
            outbox: Outbox::default(),
            store: Store::default(),
            bus: BusState::default(),
            restart: Restart::No,
        }
    }

    /// The present configuration.
    pub const fn configuration(&self) -> &Configuration {
        &self.configuration
    }

    /// The node-id in force.
    pub const fn node(&self) -> NodeId {
        self.node
    }

    /// The bitrate in force: the one that the shell sets the controller to.
    pub const fn bitrate(&self) -> Bitrate {
        self.bitrate
    }

    /// Present state; never [`NmtState::BootUp`].
    pub const fn state(&self) -> NmtState {
        self.state
    }

    /// Layout of its PDOs.
    pub fn layout(&self) -> Layout {
        self.configuration.layout(self.variant.channels)
    }

    /// Takes a frame that arrived at `now`, microseconds. A frame for another node or of another protocol
    /// changes nothing, except that an error which was lost with the bus is sent again.
    pub fn handle_frame(&mut self, frame: &Frame, now: u64) {
        if self.restart != Restart::No {
            return;
        }
        self.now = now;
        self.outbox.errors.receive();
        match ToNode::decode(frame) {
            Ok(ToNode::Nmt { command, target }) => self.handle_nmt(command, target),
            Ok(ToNode::Sync) => self.trigger(PdoKind::Sync),
            Ok(ToNode::RequestPdo { node, bytes }) if node == self.node => {
                if bytes == self.layout().length() {
                    self.trigger(PdoKind::Remote);
                }
            }
            Ok(ToNode::Sdo { node, request }) if node == self.node => self.handle_sdo(request),
            Err(DecodeError::NmtCommand(target)) => self.handle_unknown_nmt(target),
            Ok(_) | Err(_) => {}
        }
    }

    /// Takes a sample, at the rate that the variant says.
    pub fn handle_sample(&mut self, sample: Sample) {
        self.sensing.take(sample, &self.variant, &self.configuration);
    }

    /// Takes the state of the CAN controller, as often as the shell reads it. Off the bus no frame is handed
    /// out, and positions and answers that wait are dropped; the shell must drop what waits in the
    /// controller. An error that was among that is sent again.
    pub fn handle_bus_state(&mut self, state: BusState) {
        let before = core::mem::replace(&mut self.bus, state);
        if before.error == ErrorState::Active && state.error == ErrorState::Passive {
            self.outbox.errors.note(ErrorCode::Passive, self.now);
        }
        if before.is_off() != state.is_off() {
            self.outbox.discard_present();
        }
        if state.is_off() && !before.is_off() {
            self.outbox.errors.lose(self.now);
        }
    }

    /// Takes the result of storing the configuration of [`Self::poll_store`]. A shell that could not read its
    /// memory at power-up passes false, too.
    pub fn handle_store(&mut self, done: bool) {
        self.store.finish(done);
        if !done {
            self.outbox.errors.note(ErrorCode::Generic, self.now);
        }
    }

    /// Advances time to `now`, microseconds.
    pub fn poll(&mut self, now: u64) {
        self.now = now;
        if self.restart != Restart::No {
            return;
        }
        let autostart = self.configuration.autostart();
        if self.heartbeat.is_due(now, autostart) && self.configuration.heartbeat() {
            self.outbox.put_heartbeat();
        }
        // A period begins only once there is a reading to send.
        let ready =
            self.state == NmtState::Operational && self.sensing.reading(&self.configuration).is_some();
        let period = self.period();
        if ready && self.timer.is_due(now, period, pdo::offset(&self.configuration, self.node, period)) {
            self.trigger(PdoKind::Timer);
        }
    }

    /// Latest time of the next poll, microseconds, if nothing is handled until then.
    pub fn next_poll(&self) -> u64 {
        let timer = match self.period() {
            Some(_) if self.state == NmtState::Operational => self.timer.due().unwrap_or(self.now),
            _ => u64::MAX,
        };
        let error = self.outbox.errors.due_after(self.now).unwrap_or(u64::MAX);
        self.heartbeat.due().unwrap_or(self.now).min(timer).min(error)
    }

    /// The next frame to send; none while the controller is off the bus, or when a restart has been asked
    /// for.
    pub fn poll_frame(&mut self) -> Option<Frame> {
        if self.bus.is_off() || self.restart != Restart::No {
            return None;
        }
        let message = self.outbox.pop(self.state, self.now)?;
        Some(message.encode(self.node, self.layout()))
    }

    /// The next configuration to store; at most one is under way.
    pub fn poll_store(&mut self) -> Option<Configuration> {
        let due = self.store.begin(self.now, self.restart != Restart::No);
        due.then_some(self.configuration)
    }

    /// The switching outputs: high while the position is above the comparator's value. Low before the first
    /// sample.
    pub const fn outputs(&self) -> [bool; 2] {
        self.sensing.outputs()
    }

    /// Returns whether to restart the device now; true only once. Written values are stored by then, unless
    /// the memory has not answered for a second.
    pub fn take_reset(&mut self) -> bool {
        let Restart::By(latest) = self.restart else { return false };
        let due = self.store.is_idle() || self.now >= latest;
        if due {
            self.restart = Restart::Told;
        }
        due
    }

    /// Period of PDO1, microseconds; `None` if it is not sent.
    pub fn period(&self) -> Option<u64> {
        pdo::period(&self.configuration, self.layout(), self.bitrate)
    }

    /// Puts the present reading into the PDO of this kind, in Operational.
    fn trigger(&mut self, kind: PdoKind) {
        if self.state != NmtState::Operational {
            return;
        }
        if let Some(reading) = self.sensing.reading(&self.configuration) {
            self.outbox.put_pdo(kind, reading);
        }
    }
}
