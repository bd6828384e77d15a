//! What the node asks of the flash, and what it makes of the answers.

use super::Node;
use crate::bus::narmotion::{FromDrive, MotorMode, ParameterStatus};
use crate::dictionary::number;
use crate::motor::event::Health;
use crate::motor::fault::FaultWord;
use crate::motor::state::State;
use crate::storage::{Opened, Part, Report, Request};
use serde::{Deserialize, Serialize};

/// Least time from one store to the next, ms: bounds the wear of the flash.
const STORE_MS: u64 = 1000;
/// A start that was asked for before the flash is written is in the status by then, ms.
pub(super) const SETTLE_MS: u64 = 5;
/// A flash that does not answer is looked for this often, ms.
const OPEN_MS: u64 = 1000;

/// The node's side of the flash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Flash {
    /// There is a shell that serves requests.
    attached: bool,
    /// Storing stops the control tick.
    at_rest_only: bool,
    /// The stored parameters are known: they were there at power-up, or came later.
    loaded: bool,
    health: Health,
    /// A request has been handed out and not been answered.
    asked: bool,
    /// A part waits to be stored, or is being stored.
    storing: Option<Storing>,
    /// Tick of the last `poll`.
    now: u64,
    /// No store before this tick.
    store_from: u64,
    /// No search for a missing flash before this tick.
    open_from: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Storing {
    part: Part,
    /// The command parameter that is answered when it is done.
    command: Option<u16>,
}

impl Flash {
    /// Time goes on.
    pub(super) const fn advance(&mut self, now: u64) {
        self.now = now;
    }

    /// Tick of the last `poll`.
    #[cfg(feature = "update")]
    pub(super) const fn now(&self) -> u64 {
        self.now
    }

    /// What the self-tests and the store said last.
    pub(super) const fn note_health(&mut self, health: Health) {
        self.health = health;
    }

    /// What was noted last.
    pub(super) const fn health(&self) -> Health {
        self.health
    }

    /// The flash is there and has our layout.
    pub(super) fn is_ready(&self) -> bool {
        let unusable = FaultWord::STORE_ABSENT.union(FaultWord::STORE_MISMATCH);
        self.attached && !self.health.store_faults.intersects(unusable)
    }

    /// A write of 1 to this command is answered when the flash has answered.
    pub(super) fn answers_later(&self, number: u16) -> bool {
        self.storing.is_some_and(|storing| storing.command == Some(number))
    }

    /// [`Node::store_at_rest_only`].
    const fn is_for_rest(&self) -> bool {
        cfg!(feature = "code-flash") && self.at_rest_only
    }

    fn is_absent(&self) -> bool {
        self.health.store_faults.contains(FaultWord::STORE_ABSENT)
    }
}

impl Node {
    /// Joins the node to a flash, at power-up: from now on requests are taken by [`Node::poll_storage`]. `opened` is what
    /// the flash answered to [`Request::Open`], and the node was made with its parameters.
    pub fn attach_storage(&mut self, opened: &Opened) {
        self.flash.attached = true;
        self.flash.loaded = !opened.faults.contains(FaultWord::STORE_ABSENT);
        self.log.set_memory(opened.log);
        self.set_store_faults(opened.faults);
    }

    /// The flash is the one that the code runs from: while it is written no control tick runs. So no motor starts while something is stored, and what waits to be stored
    /// waits until the bridge is off. At power-up.
    #[cfg(feature = "code-flash")]
    pub const fn store_at_rest_only(&mut self) {
        self.flash.at_rest_only = true;
    }

    /// The next thing to ask of the flash; at most one request is under way. Without a flash there is none.
    #[inline(never)]
    pub fn poll_storage(&mut self) -> Option<Request> {
        if !self.flash.attached || self.flash.asked {
            return None;
        }
        let request = self.next_request()?;
        self.flash.asked = true;
        Some(request)
    }

    /// Takes what has become of the last request.
    pub fn handle_storage(&mut self, report: Report) {
        self.flash.asked = false;
        match report {
            Report::Opened(opened) => self.adopt(&opened),
            Report::Stored { done, log } => {
                self.log.set_memory(log);
                self.finish_store(done);
            }
            Report::Log { done, memory } => {
                self.log.set_memory(memory);
                if !self.log.finish(done) {
                    self.set_store_faults(self.flash.health.store_faults | FaultWord::STORE_ABSENT);
                }
            }
            Report::Record(record) => self.log.handle_record(record),
        }
    }

    /// A rising edge of parameter 256 or 257.
    pub(super) fn begin_store(&mut self, part: Part, number: u16) -> ParameterStatus {
        let flash = &self.flash;
        let possible = flash.attached && !flash.is_absent() && flash.storing.is_none();
        if !possible || flash.now < flash.store_from {
            return ParameterStatus::Storage;
        }
        self.flash.storing = Some(Storing { part, command: Some(number) });
        if self.flash.is_for_rest() {
            self.flash.store_from = self.flash.now.saturating_add(self.ticks(SETTLE_MS));
        }
        ParameterStatus::Done
    }

    /// The flash that the code runs from is written, or is about to be: no motor starts.
    pub(super) fn storing_forbids(&self, mode: MotorMode) -> bool {
        let Flash { asked, storing, .. } = self.flash;
        let starts = matches!(mode, MotorMode::Drive | MotorMode::Reverse);
        self.flash.is_for_rest() && starts && (asked || storing.is_some()) && !self.status.state.is_driving()
    }

    /// Whether a store would disturb nobody.
    const fn may_store(&self) -> bool {
        !self.flash.is_for_rest() || !self.status.state.is_driving()
    }

    /// Whether the factory set can be stored now; without a flash there is nothing to store it on.
    pub(super) fn can_store_factory(&self) -> bool {
        self.flash.storing.is_none()
    }

    /// The set in force is stored, as soon as that is allowed again.
    pub(super) fn store_factory(&mut self) {
        if self.flash.attached && !self.flash.is_absent() {
            self.flash.storing = Some(Storing { part: Part::Set, command: None });
        }
    }

    fn next_request(&mut self) -> Option<Request> {
        let may_store = self.may_store();
        let flash = &mut self.flash;
        if flash.is_absent() {
            // What comes with it may change everything: not under a motor that turns.
            let quiet = matches!(self.status.state, State::Initialization | State::Standby | State::Fault);
            let due = quiet && flash.now >= flash.open_from;
            return due.then_some(Request::Open);
        }
        let now = flash.now >= flash.store_from && may_store;
        if let Some(storing) = flash.storing.filter(|_| now) {
            return Some(Request::Store(self.parameters.clone(), storing.part));
        }
        if !flash.is_ready() {
            return None;
        }
        self.log.next_request(self.status.state.is_driving())
    }

    /// A flash that was missing answers, or still does not. Its parameters are taken over only if the drive has none of its own
    /// yet: what a master has written since must not vanish.
    fn adopt(&mut self, opened: &Opened) {
        self.flash.open_from = self.flash.now.saturating_add(self.ticks(OPEN_MS));
        self.log.set_memory(opened.log);
        self.set_store_faults(opened.faults);
        if self.flash.loaded || opened.faults.contains(FaultWord::STORE_ABSENT) {
            return;
        }
        self.flash.loaded = true;
        for (row, raw) in opened.parameters.iter() {
            if Part::Set.contains(row) || Part::Once.contains(row) {
                self.put(row.number, raw);
            }
        }
        self.drop_what_is_lacking();
        self.log.restart();
        self.after_change();
        self.calibrate_inputs();
    }

    fn finish_store(&mut self, done: bool) {
        let Some(storing) = self.flash.storing.take() else { return };
        self.flash.store_from = self.flash.now.saturating_add(self.ticks(STORE_MS));
        self.flash.loaded = true;
        let faults = if done { FaultWord::empty() } else { FaultWord::STORE_ABSENT };
        self.set_store_faults(faults);
        let Some(number) = storing.command else { return };
        if !done {
            self.put(number, 0);
        }
        let status = if done { ParameterStatus::Done } else { ParameterStatus::Storage };
        let value = self.read_parameter(number).unwrap_or(0);
        self.send(FromDrive::Parameter { number, value, status });
    }

    fn set_store_faults(&mut self, store_faults: FaultWord) {
        if self.flash.health.store_faults != store_faults {
            self.handle_health(Health { store_faults, ..self.flash.health });
        }
    }

    /// Control ticks of a time in ms.
    pub(super) fn ticks(&self, milliseconds: u64) -> u64 {
        milliseconds * u64::from(self.board.tick_rate / 1000).max(1)
    }
}

/// The part that a command stores.
pub(super) const fn part_of(command: u16) -> Part {
    if command == number::STORE_ONCE { Part::Once } else { Part::Set }
}
