//! The node's requests to the flash, and its use of the reports.

use super::Node;
use super::requests::Refused;
use crate::bus::narmotion::{FromDrive, ParameterStatus};
use crate::dictionary::{Dictionary, PARAMETER_COUNT, Parameter, Parameters, number};
use crate::motor::guard::fault::FaultWord;
use crate::motor::machine::event::Health;
use crate::motor::machine::state::State;
use crate::storage::{FlashReply, FlashTask, Opened, Part};
use serde::{Deserialize, Serialize};

/// Shortest time between two stores by command, ms: limits the wear of the flash.
const STORE_MS: u64 = 1000;
/// Time from a write to the automatic store, ms; values written meanwhile are stored with it. So there is at
/// most one such store a second.
const AUTOMATIC_MS: u64 = 1000;
/// Wait before the flash is written, ms: after it the status shows a start that was requested before.
pub(super) const SETTLE_MS: u64 = 5;
/// Period of the search for a flash that does not answer, ms.
const OPEN_MS: u64 = 1000;

/// The node's side of the flash.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Flash {
    /// There is a shell that serves requests.
    attached: bool,
    /// Storing stops the control tick.
    at_rest_only: bool,
    /// The stored parameters are known: from power-up on, or since later.
    loaded: bool,
    health: Health,
    /// A request has been handed out and not been answered.
    asked: bool,
    /// The store that waits to begin.
    wanted: Option<Storing>,
    /// The store that is under way.
    storing: Option<Storing>,
    /// The set in force is not stored: the automatic store is due from this tick on.
    due: Option<u64>,
    /// Parameters that were written since power-up, or since the restore.
    written: Written,
    /// Factory values were restored: parameters that are not in `written` have their factory values in the
    /// store.
    restored: bool,
    /// Tick of the last `poll`.
    now: u64,
    /// Earliest tick of the next store by command.
    store_from: u64,
    /// Tick by which the status shows a start that was under way; counts only if the code runs from this
    /// flash.
    settled_from: u64,
    /// Earliest tick of the next search for a missing flash.
    open_from: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Storing {
    part: Part,
    /// The command parameter that is answered when the store is done.
    command: Option<u16>,
}

/// A set of parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct Written([u32; PARAMETER_COUNT.div_ceil(32)]);

impl Written {
    fn note(&mut self, number: u16) {
        let index = Dictionary::index(number).unwrap_or(usize::MAX);
        if let Some(word) = self.0.get_mut(index / 32) {
            *word |= 1 << (index % 32);
        }
    }

    fn contains(&self, number: u16) -> bool {
        let index = Dictionary::index(number).unwrap_or(usize::MAX);
        self.0.get(index / 32).is_some_and(|word| word & 1 << (index % 32) != 0)
    }
}

impl Flash {
    /// Advances time to tick `now`.
    pub(super) const fn advance(&mut self, now: u64) {
        self.now = now;
    }

    /// Tick of the last `poll`.
    #[cfg(feature = "update")]
    pub(super) const fn now(&self) -> u64 {
        self.now
    }

    /// Notes the condition of the self-tests and of the store.
    pub(super) const fn note_health(&mut self, health: Health) {
        self.health = health;
    }

    /// The condition that was noted last.
    pub(super) const fn health(&self) -> Health {
        self.health
    }

    /// Returns whether the flash answers and has this firmware's layout.
    pub(super) fn is_ready(&self) -> bool {
        let unusable = FaultWord::STORE_ABSENT.union(FaultWord::STORE_MISMATCH);
        self.attached && !self.health.store_faults.intersects(unusable)
    }

    /// Returns whether a write of 1 to this command is answered only after the flash's report.
    pub(super) fn answers_later(&self, number: u16) -> bool {
        [self.wanted, self.storing].iter().flatten().any(|storing| storing.command == Some(number))
    }

    /// Returns whether it is written at rest only: [`Node::store_at_rest_only`].
    const fn is_for_rest(&self) -> bool {
        cfg!(feature = "code-flash") && self.at_rest_only
    }

    fn is_absent(&self) -> bool {
        self.health.store_faults.contains(FaultWord::STORE_ABSENT)
    }

    /// Returns whether the automatic store may write: only to a flash without a fault. The content of a
    /// faulty one may still be needed, and is overwritten only on demand.
    fn stores_by_itself(&self) -> bool {
        self.attached && self.health.store_faults.is_empty()
    }

    /// Returns whether no store is under way, and none waits that is possible.
    pub(super) fn is_idle(&self) -> bool {
        let waits = self.wanted.is_some() && !self.is_absent();
        self.storing.is_none() && !waits && (self.due.is_none() || !self.stores_by_itself())
    }

    /// Makes a waiting automatic store due now, for example before a restart.
    pub(super) fn hurry(&mut self) {
        self.due = self.due.map(|_| self.now);
    }
}

impl Node {
    /// Connects the node to a flash, at power-up: from now on [`Node::poll_storage`] returns requests.
    /// `opened` is the flash's report on [`FlashTask::Open`]; the node was made with its parameters.
    pub fn attach_storage(&mut self, opened: &Opened) {
        self.flash.attached = true;
        self.flash.loaded = !opened.faults.contains(FaultWord::STORE_ABSENT);
        self.log.set_memory(opened.log);
        self.set_store_faults(opened.faults);
    }

    /// States that the code runs from this flash: while it is written no control tick runs. So no motor
    /// starts during a store, and a store waits until the bridge is off. Call it at power-up.
    #[cfg(feature = "code-flash")]
    pub const fn store_at_rest_only(&mut self) {
        self.flash.at_rest_only = true;
    }

    /// Returns the next request to the flash; at most one is under way. Without a flash there is none.
    #[inline(never)]
    pub fn poll_storage(&mut self) -> Option<FlashTask> {
        if !self.flash.attached || self.flash.asked {
            return None;
        }
        let request = self.next_request()?;
        self.flash.asked = true;
        Some(request)
    }

    /// Takes the report on the last request.
    pub fn handle_storage(&mut self, report: FlashReply) {
        self.flash.asked = false;
        match report {
            FlashReply::Opened(opened) => self.adopt(&opened),
            FlashReply::Stored { done, log } => {
                self.log.set_memory(log);
                self.finish_store(done);
            }
            FlashReply::Log { done, memory } => {
                self.log.set_memory(memory);
                if !self.log.finish(done) {
                    self.set_store_faults(self.flash.health.store_faults | FaultWord::STORE_ABSENT);
                }
            }
            FlashReply::Record(record) => self.log.handle_record(record),
        }
    }

    /// Begins a store, at a rising edge of parameter 256 or 257.
    pub(super) fn begin_store(&mut self, part: Part, number: u16) -> ParameterStatus {
        let flash = &self.flash;
        let is_busy =
            flash.wanted.is_some() || flash.storing.is_some_and(|storing| storing.command.is_some());
        if !flash.attached || flash.is_absent() || is_busy || flash.now < flash.store_from {
            return ParameterStatus::Storage;
        }
        self.want(Storing { part, command: Some(number) });
        ParameterStatus::Done
    }

    fn want(&mut self, store: Storing) {
        self.flash.wanted = Some(store);
        self.flash.settled_from = self.flash.now.saturating_add(self.ticks(SETTLE_MS));
    }

    /// Stores factory values in place of the stored set. They, and values written from now on, are in force
    /// after the next reboot. Refused if the flash does not answer, or another store waits; without a flash
    /// there is nothing to restore.
    pub(super) fn store_factory(&mut self) -> Result<(), Refused> {
        if !self.flash.attached {
            return Ok(());
        }
        if self.flash.is_absent() || self.flash.wanted.is_some() {
            return Err(Refused);
        }
        (self.flash.restored, self.flash.written) = (true, Written::default());
        self.want(Storing { part: Part::Set, command: None });
        Ok(())
    }

    /// Notes a parameter that was written and is to be stored. `automatic`: parameter 307 is or was 1.
    /// `is_new`: it had another value.
    pub(super) fn note_written(&mut self, row: &Parameter, automatic: bool, is_new: bool) {
        let is_new = is_new || (self.flash.restored && !self.flash.written.contains(row.number));
        self.flash.written.note(row.number);
        if !is_new || !self.flash.attached || !Part::Set.contains(row) {
            return;
        }
        if automatic && self.flash.due.is_none() {
            self.flash.due = Some(self.flash.now.saturating_add(self.ticks(AUTOMATIC_MS)));
        }
        if row.number == number::AUTOMATIC_STORE {
            // It is stored with the values written before it, and without later ones.
            self.flash.hurry();
        }
    }

    /// Returns the set that a store writes: the one in force or, after a restore, factory values and the
    /// values written since.
    fn kept(&self) -> Parameters {
        let mut kept = self.parameters.clone();
        let Flash { restored, written, .. } = &self.flash;
        let is_factory =
            |row: &Parameter| *restored && Part::Set.contains(row) && !written.contains(row.number);
        for row in Dictionary::rows().filter(|row| is_factory(row)) {
            let _ = kept.set(row.number, row.factory_raw());
        }
        kept
    }

    /// Returns whether commands wait, so that no motor starts: the flash that the code runs from is being
    /// written, or is about to be.
    pub(super) fn holds_commands(&self) -> bool {
        let Flash { asked, wanted, .. } = self.flash;
        self.flash.is_for_rest() && (asked || wanted.is_some()) && !self.status.state.is_driving()
    }

    /// Returns whether a store is possible now: it would not stop the control tick of a driven motor.
    const fn may_store(&self) -> bool {
        !self.flash.is_for_rest() || !self.status.state.is_driving()
    }

    fn next_request(&mut self) -> Option<FlashTask> {
        if self.flash.is_absent() {
            // The parameters of a flash that answers again may change everything: not while a motor is
            // driven.
            let quiet = matches!(self.status.state, State::Initialization | State::Standby | State::Fault);
            let due = quiet && self.flash.now >= self.flash.open_from;
            return due.then_some(FlashTask::Open);
        }
        if self.may_store() {
            let is_due = self.flash.due.is_some_and(|due| self.flash.now >= due);
            if is_due && self.flash.wanted.is_none() && self.flash.stores_by_itself() {
                self.want(Storing { part: Part::Set, command: None });
            }
            let is_settled = !self.flash.is_for_rest() || self.flash.now >= self.flash.settled_from;
            if let Some(storing) = self.flash.wanted.take_if(|_| is_settled) {
                if storing.part == Part::Set {
                    self.flash.due = None;
                }
                self.flash.storing = Some(storing);
                return Some(FlashTask::Store(self.kept(), storing.part));
            }
        }
        if !self.flash.is_ready() {
            return None;
        }
        self.log.next_request(self.status.state.is_driving())
    }

    /// Takes the report of a flash that was missing, and answers now or still does not. Its parameters are
    /// taken over only if the stored parameters are not known yet, and without those that a master has
    /// written since: they must not be lost.
    fn adopt(&mut self, opened: &Opened) {
        self.flash.open_from = self.flash.now.saturating_add(self.ticks(OPEN_MS));
        self.log.set_memory(opened.log);
        self.set_store_faults(opened.faults);
        if self.flash.loaded || opened.faults.contains(FaultWord::STORE_ABSENT) {
            return;
        }
        self.flash.loaded = true;
        for (row, raw) in opened.parameters.iter() {
            let is_stored = Part::Set.contains(row) || Part::Once.contains(row);
            if is_stored && !self.flash.written.contains(row.number) {
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
        self.flash.loaded = true;
        let faults = if done { FaultWord::empty() } else { FaultWord::STORE_ABSENT };
        self.set_store_faults(faults);
        self.answer_store(storing, done);
        if done {
            return;
        }
        let wanted = self.flash.wanted.take();
        // The store has failed. The drive stores the set again when the flash is back, also for a restore
        // that waited behind it.
        if [Some(storing), wanted].iter().flatten().any(|store| store.part == Part::Set) {
            self.flash.due = Some(self.flash.now);
        }
        if let Some(wanted) = wanted {
            self.answer_store(wanted, false);
        }
    }

    /// Answers the command that requested the store, if it was one.
    fn answer_store(&mut self, storing: Storing, done: bool) {
        let Some(number) = storing.command else { return };
        self.flash.store_from = self.flash.now.saturating_add(self.ticks(STORE_MS));
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
        milliseconds * u64::from(self.board.tick_rate) / 1000
    }
}

/// The part that a command stores.
pub(super) const fn part_of(command: u16) -> Part {
    if command == number::STORE_ONCE { Part::Once } else { Part::Set }
}
