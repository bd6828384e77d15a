//! The virtual scope (8.4.4 of the specification): signals of the drive at the control rate, around a trigger.
//!
//! ```text
//!  Request --> Scope, beside the Drive in the control tick's half --> Report
//!
//!             arm          trigger                  full
//!   Idle ----------> Armed ----------> Recording ----------> Done     "before" samples are kept from
//!                      |<-- before -->|<---- the rest ---->|          before the trigger
//! ```
//!
//! The memory is a ring of whole samples, and stays with the tick's half: a record is read from there in blocks of three words, one a
//! tick, so neither half ever waits for the other, and none writes what the other reads. Nothing but another arming takes a record away.

mod setup;

use crate::motor::{self, Drive, Samples};
use serde::{Deserialize, Serialize};
pub use setup::{SIGNALS_A_TICK, Setup, Threshold, Trigger, period};

/// Words of a scope that holds as much as parameter 23 can ask for of one signal: 8 KiB.
pub const WORDS: usize = 4096;

/// What the background asks of the scope.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request {
    /// Wait for a trigger. What was recorded is lost.
    Arm(Setup),
    /// Do not wait any longer.
    Force,
    /// Read the record from its first word.
    Read,
}

/// What the scope tells the background.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Report {
    /// It has changed to this.
    State(State),
    /// Part of the record.
    Block(Block),
}

/// Three words of the record; zeros follow the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Block {
    /// Place of the first one.
    pub address: u16,
    /// Samples of the signals in turn, oldest first.
    pub words: [u16; 3],
    /// None follow.
    pub last: bool,
}

/// What the scope does (parameter 260).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum State {
    /// Nothing.
    #[default]
    Idle = 0,
    /// It waits for its trigger, and keeps what goes before.
    Armed = 1,
    /// It was triggered, and fills its memory.
    Recording = 2,
    /// The record can be read.
    Done = 3,
}

/// The scope: memory of its shell's choice, and what it does with it.
#[derive(Clone, Debug)]
pub struct Scope<M> {
    memory: M,
    setup: Setup,
    state: State,
    /// The state has not been told yet.
    changed: bool,
    /// Words of a sample, of the record, and where the next sample goes.
    wide: usize,
    length: usize,
    next: usize,
    /// Signals of the next sample that have been read.
    scanned: usize,
    /// Ticks to the sample after it.
    wait: u16,
    /// Samples that are to come: before the trigger counts, or until the record is full.
    left: u16,
    /// The trigger has come, and some samples before it have not.
    fired: bool,
    before: Before,
    /// Words of the record that have been read, while it is.
    read: Option<usize>,
}

/// What a trigger compares with.
#[derive(Clone, Copy, Debug, Default)]
struct Before {
    holds: bool,
    state: motor::State,
    faults: u32,
}

impl<M: AsRef<[u16]> + AsMut<[u16]>> Scope<M> {
    /// An idle scope. Without room for one sample it stays so.
    pub fn new(memory: M) -> Self {
        Self {
            memory,
            setup: Setup::default(),
            state: State::Idle,
            changed: false,
            wide: 0,
            length: 0,
            next: 0,
            scanned: 0,
            wait: 0,
            left: 0,
            fired: false,
            before: Before::default(),
            read: None,
        }
    }

    /// What it does.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Takes a request. One that does not fit the state changes nothing.
    pub fn handle(&mut self, request: Request) {
        match request {
            Request::Arm(setup) => self.arm(setup),
            Request::Force if self.state == State::Armed => self.fired = true,
            Request::Read if self.state == State::Done => self.read = Some(0),
            Request::Force | Request::Read => {}
        }
    }

    fn arm(&mut self, setup: Setup) {
        let wide = setup.signals.len();
        let room = self.memory.as_ref().len().checked_div(wide).unwrap_or(0);
        let samples = room.min(setup.samples.into());
        (self.read, self.fired) = (None, false);
        (self.state, self.changed) = (State::Idle, true);
        if samples == 0 {
            return;
        }
        (self.wide, self.length, self.next) = (wide, wide * samples, 0);
        self.left = (samples - 1).min(setup.before.into()) as u16;
        (self.wait, self.scanned) = (0, wide);
        self.setup = Setup { before: self.left, prescaler: setup.period(), ..setup };
        // A level that holds already is no edge; what the drive does now is no change.
        self.before = Before { holds: true, state: motor::State::Initialization, faults: u32::MAX };
        self.state = State::Armed;
    }

    /// One control tick, after the drive's.
    #[inline]
    pub fn step(&mut self, drive: &Drive, samples: &Samples) {
        if matches!(self.state, State::Armed | State::Recording) {
            self.record(drive, samples);
        }
    }

    #[inline(never)]
    fn record(&mut self, drive: &Drive, samples: &Samples) {
        if self.state == State::Armed {
            self.watch(drive, samples);
        }
        if self.wait == 0 {
            (self.wait, self.scanned) = (self.setup.prescaler, 0);
        }
        self.wait -= 1;
        if self.scanned == self.wide {
            return;
        }
        let begin = self.next + self.scanned;
        self.scanned = (self.scanned + SIGNALS_A_TICK).min(self.wide);
        let end = self.next + self.scanned;
        if let Some(words) = self.memory.as_mut().get_mut(begin..end)
            && let Some(signals) = self.setup.signals.get(begin - self.next..)
        {
            drive.sample(signals, self.setup.speed, samples, words);
        }
        if self.scanned == self.wide {
            self.complete(end);
        }
    }

    /// A sample is complete.
    #[inline]
    fn complete(&mut self, end: usize) {
        self.next = if end >= self.length { 0 } else { end };
        self.left = self.left.saturating_sub(1);
        if self.state == State::Recording && self.left == 0 {
            (self.state, self.changed) = (State::Done, true);
        }
    }

    /// Has the trigger come? A level that is crossed before there are enough samples is not the one that was meant; a fault is.
    fn watch(&mut self, drive: &Drive, samples: &Samples) {
        let enough = self.left == 0;
        let before = self.before;
        match self.setup.trigger {
            Trigger::Forced => {}
            Trigger::Level(threshold) | Trigger::Edge(threshold) => {
                let sample = drive.sample_of(threshold.signal, self.setup.speed, samples);
                self.before.holds = threshold.holds(sample);
                let edge = matches!(self.setup.trigger, Trigger::Edge(_));
                self.fired |= enough && self.before.holds && !(edge && before.holds);
            }
            Trigger::StateChange | Trigger::Fault => {
                (self.before.state, self.before.faults) = (drive.state(), drive.faults().bits());
                // The first look only learns what there is.
                let learns = before.faults == u32::MAX;
                self.fired |= !learns
                    && if self.setup.trigger == Trigger::Fault {
                        self.before.faults & !before.faults != 0
                    } else {
                        self.before.state != before.state
                    };
            }
        }
        if self.fired && enough {
            let samples = self.length.checked_div(self.wide).unwrap_or(0) as u16;
            self.left = samples.saturating_sub(self.setup.before);
            // The trigger's own tick is the first one after it; a sample that was being read is dropped.
            self.wait = 0;
            (self.state, self.changed) = (State::Recording, true);
        }
    }

    /// There is something to tell.
    #[inline]
    pub const fn has_report(&self) -> bool {
        self.changed || self.read.is_some()
    }

    /// What there is to tell, at most one thing a tick. Ask only if it can be taken: it is told once.
    #[inline]
    pub fn poll(&mut self) -> Option<Report> {
        if core::mem::take(&mut self.changed) {
            return Some(Report::State(self.state));
        }
        self.read.map(|from| Report::Block(self.read_on(from)))
    }

    fn read_on(&mut self, from: usize) -> Block {
        let mut block = Block { address: from as u16, ..Block::default() };
        // The ring is full, so the oldest sample is where the next one would go.
        let mut place = self.next + from;
        for (word, _) in block.words.iter_mut().zip(from..self.length) {
            if place >= self.length {
                place -= self.length;
            }
            *word = self.memory.as_ref().get(place).copied().unwrap_or(0);
            place += 1;
        }
        block.last = from + block.words.len() >= self.length;
        self.read = (!block.last).then_some(from + block.words.len());
        block
    }
}
