//! The device around the motor: accepts the master's frames, keeps the parameters, and broadcasts the tick's
//! reports. A pure state machine without a clock, a bus or a flash of its own.
//!
//! ```text
//!  frames ----- handle_frame --> +------+ --- poll_frame --> frames
//!  Status ---- handle_status --> | Node | --- poll_event --> Event, to the control tick
//!  slow inputs handle_inputs --> |      | -- poll_action --> what only the shell can do
//!  ScopeReply - handle_scope --> |      | --- poll_scope --> ScopeTask, to the scope in the control tick's half
//!  FlashReply handle_storage --> |      | - poll_storage --> FlashTask
//!  SlotReply - handle_update --> |      | -- poll_update --> SlotTask, for the bootloader's slot (feature `update`)
//!  controller handle_bus_state > |      |
//!  time ---------------- poll -> +------+ ------- outputs -> digital lines, hall supply
//! ```
//!
//! Call each `handle_*` when its event happens, then `poll` with the time, then each `poll_*` until it has
//! nothing left; `poll_bulk_frame` only as fast as the bus takes its frames.
//!
//! Functions that a shell calls stay out of line, and so do the halves of a [device](crate::device): inlined
//! into the shell's loop, whose variables include a whole drive and its node, each access to a field would
//! take two instructions.

mod broadcast;
mod bulk;
mod commands;
mod condition;
mod description;
mod equipment;
mod inputs;
mod link;
mod log;
mod motion;
mod outbox;
mod parameters;
mod requests;
mod scale;
mod scope;
mod storage;
#[cfg(feature = "update")]
pub mod update;

pub use crate::description::Identity;
pub use condition::{Diagnostics, ResetCause, SelfTests};
use inputs::ACCELEROMETER;
pub use inputs::SlowInputs;

use crate::bus::Frame;
use crate::bus::narmotion::{Addresses, DigitalOutputs};
use crate::dictionary::{Parameters, number};
use crate::motor::coefficients::Coefficients;
use crate::motor::guard::fault::FaultWord;
use crate::motor::machine::event::{Event, Health, SlowMeasurements, Status};
use crate::motor::sense::front_end::{Board, Equipment};
use broadcast::Autosend;
use bulk::Turn;
use commands::Commands;
use description::Download;
use link::Link;
use log::{LOGS, Log};
use motion::Motion;
use outbox::Outbox;
use parameters::Edges;
use scope::ScopeLink;
use serde::{Deserialize, Serialize};
use storage::Flash;

/// An action that the shell does for the node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Action {
    /// Restart the device. Every frame queued before has been polled by then, and written parameters are
    /// stored.
    Reboot,
}

/// Levels that the shell applies to the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Outputs {
    /// DSIO1 and DSIO2.
    pub digital: DigitalOutputs,
    /// Supply of the hall sensors.
    pub hall_supply: bool,
}

/// The device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Node {
    identity: Identity,
    board: Board,
    addresses: Addresses,
    /// The device number in force.
    device_number: u16,
    parameters: Parameters,
    edges: Edges,
    commands: Commands,
    /// The last report of the tick.
    status: Status,
    /// Sectors turned since power-up, without the wrap of the report.
    sectors: i64,
    /// Mechanical position at sector 0, 0.01 degrees (parameters 16 and 17).
    position_offset: i32,
    /// The rotor may have turned unseen since the position was set (parameter 17), or since power-up.
    position_lost: bool,
    /// The last reading; `None` before the first.
    inputs: Option<SlowInputs>,
    motion: Motion,
    digital: DigitalOutputs,
    hall_supply_disabled: bool,
    autosend: Autosend,
    link: Link,
    outbox: Outbox,
    download: Download,
    /// The download that sends the next bulk frame.
    turn: Turn,
    pending: Pending,
    counters: Counters,
    flash: Flash,
    log: Log,
    scope: ScopeLink,
    #[cfg(feature = "update")]
    update: update::Receiver,
    /// Parameter for which the present set does not build.
    rejected: Option<u16>,
}

/// Events that wait for the tick, besides commands; a newer one replaces an older one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Pending {
    health: Option<Health>,
    coefficients: bool,
    slow: Option<SlowMeasurements>,
    calibrate: Option<bool>,
    reboot: bool,
}

/// Counters since power-up, saturating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Counters {
    refused: u32,
    malformed: u32,
}

impl Node {
    /// A device at power-up with factory parameters.
    pub fn new(identity: Identity, board: Board) -> Self {
        Self::with_parameters(identity, board, Parameters::new())
    }

    /// A device at power-up with a stored parameter set. Addresses and device number are taken from it now
    /// and kept until reboot.
    #[inline(never)]
    pub fn with_parameters(identity: Identity, board: Board, parameters: Parameters) -> Self {
        let addresses = Addresses {
            drive: parameters.raw(number::SLAVE_CAN_ADDRESS) as u8,
            master: parameters.raw(number::MASTER_CAN_ADDRESS) as u8,
        };
        let mut node = Self {
            identity,
            board,
            addresses,
            device_number: parameters.raw(number::DEVICE_NUMBER) as u16,
            parameters,
            edges: Edges::default(),
            commands: Commands::default(),
            status: Status { command_expired: true, ..Status::default() },
            sectors: 0,
            position_offset: 0,
            position_lost: false,
            inputs: None,
            motion: Motion::default(),
            digital: DigitalOutputs::default(),
            hall_supply_disabled: false,
            autosend: Autosend::default(),
            link: Link::default(),
            outbox: Outbox::default(),
            download: Download::default(),
            turn: Turn::default(),
            pending: Pending { coefficients: true, ..Pending::default() },
            counters: Counters::default(),
            flash: Flash::default(),
            log: Log::default(),
            scope: ScopeLink::default(),
            #[cfg(feature = "update")]
            update: update::Receiver::default(),
            rejected: None,
        };
        node.show_identity();
        node.drop_what_is_lacking();
        node.commands.select_mode(&node.parameters);
        node
    }

    /// Sets the parameters that identify firmware and board.
    fn show_identity(&mut self) {
        let identity = self.identity;
        self.put(number::HARDWARE_RELEASE, identity.hardware_release.into());
        self.put(number::BUILD_NUMBER, identity.build_number.into());
        self.put(number::SOFTWARE_RELEASE, identity.software_release.into());
        self.put(number::SOURCE_MODIFIED, identity.source_modified.into());
    }

    /// The present parameter set.
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// The board that the node was made for.
    pub const fn board(&self) -> &Board {
        &self.board
    }

    /// The addresses in force.
    pub const fn addresses(&self) -> Addresses {
        self.addresses
    }

    /// The last report of the control tick.
    pub const fn status(&self) -> &Status {
        &self.status
    }

    /// Takes a report of the control tick.
    #[inline(never)]
    pub fn handle_status(&mut self, status: Status) {
        let before = core::mem::replace(&mut self.status, status);
        let turned = status.sectors.wrapping_sub(before.sectors);
        self.sectors = self.sectors.wrapping_add(turned.into());
        self.position_lost |= status.unseen;
        if !status.state.is_driving() {
            self.commands.select_mode(&self.parameters);
        }
        self.announce_faults(&before);
        self.adopt_hall_calibration(before.hall_calibration);
    }

    /// Takes a reading of the slow inputs, about every 10 ms.
    #[inline(never)]
    pub fn handle_inputs(&mut self, inputs: SlowInputs) {
        self.inputs = Some(inputs);
        if ACCELEROMETER && self.has(Equipment::ACCELEROMETER) {
            self.motion.note(inputs.calibrated_accel(&self.parameters));
        }
        self.calibrate_inputs();
    }

    /// Takes the condition of the parameter store and of the self-tests, at boot and when it changes.
    #[inline(never)]
    pub fn handle_health(&mut self, health: Health) {
        self.pending.health = Some(health);
        self.flash.note_health(health);
        let mapped = !health.store_faults.contains(FaultWord::STORE_MISMATCH);
        self.put(number::MEMORY_MAPPING_FLAG, i32::from(mapped));
    }

    /// Advances time to the control tick `now`: queues the broadcasts that are due, and samples for the log.
    #[inline(never)]
    pub fn poll(&mut self, now: u64) {
        self.flash.advance(now);
        self.run_log(now);
        #[cfg(feature = "update")]
        self.run_update();
        if !self.link.state.is_off() && self.autosend.is_due(now, &self.parameters, &self.board) {
            self.broadcast();
        }
        self.measure_description();
    }

    /// The next frame to send, control and status before measurements; none while the controller is off the
    /// bus.
    pub fn poll_frame(&mut self) -> Option<Frame> {
        if self.link.state.is_off() {
            return None;
        }
        Some(self.outbox.pop()?.frame(self.addresses))
    }

    /// The next event for the control tick.
    #[inline(never)]
    pub fn poll_event(&mut self) -> Option<Event> {
        if let Some(health) = self.pending.health.take() {
            return Some(Event::Health(health));
        }
        if core::mem::take(&mut self.pending.coefficients) {
            return Some(self.build());
        }
        if let Some(slow) = self.pending.slow.take() {
            return Some(Event::Slow(slow));
        }
        if let Some(run) = self.pending.calibrate.take() {
            return Some(Event::CalibrateHall(run));
        }
        if self.holds_commands() { None } else { self.commands.pop() }
    }

    /// Returns the next action that only the shell can do.
    #[inline(never)]
    pub fn poll_action(&mut self) -> Option<Action> {
        // Off the bus no frame is waited for.
        let is_told = self.outbox.is_empty() || self.link.state.is_off();
        let due = self.pending.reboot && is_told && self.flash.is_idle();
        self.pending.reboot &= !due;
        due.then_some(Action::Reboot)
    }

    /// Returns the levels for the board's lines.
    pub fn outputs(&self) -> Outputs {
        let enabled = self.parameters.raw(number::HALL_SUPPLY_ENABLE) != 0;
        Outputs { digital: self.digital, hall_supply: enabled && !self.hall_supply_disabled }
    }

    /// Sends the last slow reading to the tick, under the present calibration.
    fn calibrate_inputs(&mut self) {
        self.pending.slow = self.inputs.map(|inputs| inputs.calibrated(&self.parameters));
    }

    /// Builds the present set; the tick keeps the last good one if it does not build.
    fn build(&mut self) -> Event {
        match Coefficients::build(&self.parameters, &self.board) {
            Ok(coefficients) => {
                self.rejected = None;
                Event::Coefficients(coefficients)
            }
            Err(error) => {
                self.rejected = Some(error.parameter);
                Event::CoefficientsRejected
            }
        }
    }
}
