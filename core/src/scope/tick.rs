//! The control tick's half of the scope.
//!
//! ```text
//!             arm          trigger                  full
//!   Idle ----------> Armed ----------> Recording ----------> Done     "before" samples are kept from
//!                      |<-- before -->|<---- the rest ---->|          before the trigger
//! ```
//!
//! Samples of signals go round in a ring. Inputs fill one half of the memory after the other, each behind a checkpoint of the drive: so there
//! is at any time one whole half, and what has been filled of the other.

use super::inputs::{self, Before, Note};
use super::memory::{Half, Memory, Record};
use super::setup::{SIGNALS_A_TICK, Setup, Trigger};
use super::{Answer, Order, State};
use crate::motor::{self, Drive, Event, Samples};
use core::borrow::BorrowMut;

/// What the scope does with its memory. `H` holds it: a reference, or a box.
#[derive(Clone, Debug)]
pub struct Scope<H> {
    /// The keeper has it while this is idle.
    memory: Option<H>,
    setup: Setup,
    state: State,
    /// The state has not been told yet.
    changed: bool,
    /// Samples that are to come: before the trigger counts, or until the record is full.
    left: u16,
    /// The trigger has come, and some samples before it have not.
    fired: bool,
    before: Quiet,
    ring: Ring,
    course: Course,
}

/// Of signals.
#[derive(Clone, Copy, Debug, Default)]
struct Ring {
    /// Words of a sample, of the record, and where the next sample goes.
    wide: usize,
    length: usize,
    next: usize,
    /// Signals of the next sample that have been read.
    scanned: usize,
    /// Ticks to the sample after it.
    wait: u16,
}

/// Of inputs.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    /// The event of this tick.
    note: Note,
    /// The half that is being filled, if one is.
    now: Option<Half>,
    /// The other one, if it goes before without a gap.
    older: Option<Half>,
    before: Before,
    /// The trigger lies in the older half, which may not be lost any more.
    keeps: bool,
    /// Ticks that the first checkpoint may still wait for a calm one.
    patience: u8,
}

/// Words that are left in a half when its successor begins to wait for a calm tick: a checkpoint takes longer than the scope's other work, so it
/// keeps away from ticks that are long themselves.
const NEAR: usize = inputs::WORDS_MAX + 64;

/// Ticks that the first checkpoint waits so.
const PATIENCE: u8 = 16;

/// What a trigger compares with.
#[derive(Clone, Copy, Debug, Default)]
struct Quiet {
    holds: bool,
    state: motor::State,
    faults: u32,
}

impl<H> Default for Scope<H> {
    fn default() -> Self {
        Self {
            memory: None,
            setup: Setup::default(),
            state: State::Idle,
            changed: false,
            left: 0,
            fired: false,
            before: Quiet::default(),
            ring: Ring::default(),
            course: Course::default(),
        }
    }
}

impl<H: BorrowMut<Memory>> Scope<H> {
    /// What it does.
    pub const fn state(&self) -> State {
        self.state
    }

    /// The memory, if it has it: for who takes the scope apart.
    pub fn into_memory(self) -> Option<H> {
        self.memory
    }

    /// Takes an order. It is the keeper who sees to it that it fits the state.
    pub fn handle(&mut self, order: Order<H>) {
        match order {
            Order::Arm(setup, memory) => self.arm(setup, memory),
            Order::Force => self.fired |= self.state == State::Armed,
        }
    }

    fn arm(&mut self, setup: Setup, mut memory: H) {
        let room: &mut Memory = memory.borrow_mut();
        room.record = Record::Nothing;
        let (words, half) = (room.room(), room.half());
        self.memory = Some(memory);
        (self.ring, self.fired) = (Ring::default(), false);
        self.course = Course { patience: PATIENCE, ..Course::default() };
        (self.state, self.changed) = (State::Idle, true);
        if setup.inputs {
            if half == 0 {
                return;
            }
            self.left = 0;
        } else {
            let wide = setup.signals.len();
            let samples = words.checked_div(wide).unwrap_or(0).min(setup.samples.into());
            if samples == 0 {
                return;
            }
            self.ring = Ring { wide, length: wide * samples, scanned: wide, ..Ring::default() };
            self.left = (samples - 1).min(setup.before.into()) as u16;
        }
        let before = setup.before.min(setup.samples.saturating_sub(1)).min(if setup.inputs {
            u16::MAX
        } else {
            self.left
        });
        self.setup = Setup { before, prescaler: setup.period(), ..setup };
        // A level that holds already is no edge; what the drive does now is no change.
        self.before = Quiet { holds: true, state: motor::State::Initialization, faults: u32::MAX };
        self.state = State::Armed;
    }

    /// The event of this tick, before the drive takes it.
    #[inline]
    pub fn handle_event(&mut self, event: &Event) {
        if self.setup.inputs && matches!(self.state, State::Armed | State::Recording) {
            self.course.note = Note::from(event);
        }
    }

    /// One control tick, after the drive's and after its status was polled.
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
        if self.setup.inputs {
            self.record_inputs(drive, samples)
        } else {
            self.record_signals(drive, samples)
        }
    }

    fn record_signals(&mut self, drive: &Drive, samples: &Samples) {
        let ring = &mut self.ring;
        if ring.wait == 0 {
            (ring.wait, ring.scanned) = (self.setup.prescaler, 0);
        }
        ring.wait -= 1;
        if ring.scanned == ring.wide {
            return;
        }
        let begin = ring.next + ring.scanned;
        ring.scanned = (ring.scanned + SIGNALS_A_TICK).min(ring.wide);
        let end = ring.next + ring.scanned;
        if let Some(memory) = &mut self.memory
            && let Some(words) = memory.borrow_mut().words.get_mut(begin..end)
            && let Some(signals) = self.setup.signals.get(begin - ring.next..)
        {
            drive.sample(signals, self.setup.speed, samples, words);
        }
        if ring.scanned == ring.wide {
            ring.next = if end >= ring.length { 0 } else { end };
            self.count();
        }
    }

    /// A sample is complete.
    #[inline]
    fn count(&mut self) {
        self.left = self.left.saturating_sub(1);
        if self.state == State::Recording && self.left == 0 {
            self.end();
        }
    }

    #[cold]
    fn end(&mut self) {
        (self.state, self.changed) = (State::Done, true);
        let record = if self.setup.inputs {
            let halves = [self.course.older, self.course.now];
            let count = halves.iter().flatten().count() as u8;
            let [older, now] = halves.map(Option::unwrap_or_default);
            let halves = if count == 2 { [older, now] } else { [now, older] };
            Record::Inputs { rate: self.setup.tick_rate, halves, count }
        } else {
            // The ring is full, so the oldest sample is where the next one would go.
            Record::Signals { oldest: self.ring.next as u16, words: self.ring.length as u16 }
        };
        if let Some(memory) = &mut self.memory {
            memory.borrow_mut().record = record;
        }
    }

    fn record_inputs(&mut self, drive: &Drive, samples: &Samples) {
        let course = &mut self.course;
        let note = core::mem::take(&mut course.note);
        let Some(now) = course.now.as_mut().filter(|_| note != Note::Checkpoint) else {
            return self.begin_anew(note, drive, samples);
        };
        let Some(memory) = &mut self.memory else { return };
        let memory = memory.borrow_mut();
        let half = memory.half();
        let begin = usize::from(now.place) * half + usize::from(now.words);
        let room = memory.words.get_mut(begin..).unwrap_or_default();
        now.words += inputs::write(room, note, samples, &mut course.before) as u16;
        now.ticks += 1;
        let left = half.saturating_sub(now.words.into());
        self.count();
        if left < NEAR && (left < inputs::WORDS_MAX || drive.was_calm()) && self.state != State::Done {
            self.turn_over(drive, samples);
        }
    }

    /// There is no half to be filled yet, or what the drive was given cannot be kept: what was recorded does not lead here.
    #[cold]
    fn begin_anew(&mut self, note: Note, drive: &Drive, samples: &Samples) {
        if self.state == State::Recording {
            return self.end();
        }
        let course = &mut self.course;
        if course.now.take().is_some() || note == Note::Checkpoint {
            (course.older, course.patience) = (None, PATIENCE);
        }
        match course.patience.checked_sub(1) {
            Some(left) if !drive.was_calm() => course.patience = left,
            _ => self.begin(0, drive, samples),
        }
    }

    /// A half is full.
    #[cold]
    fn turn_over(&mut self, drive: &Drive, samples: &Samples) {
        if self.course.keeps {
            return self.end();
        }
        self.course.keeps = self.state == State::Recording;
        self.course.older = self.course.now;
        self.begin(self.course.now.map_or(0, |half| half.place ^ 1), drive, samples);
    }

    fn begin(&mut self, place: u8, drive: &Drive, samples: &Samples) {
        if let Some(memory) = &mut self.memory
            && let Some(checkpoint) = memory.borrow_mut().checkpoints.get_mut(usize::from(place))
        {
            *checkpoint = Some(drive.clone());
        }
        self.course.now = Some(Half { place, first: samples.tick.wrapping_add(1), ticks: 0, words: 0 });
        self.course.before = Before { tick: samples.tick, ..Before::default() };
    }

    /// Has the trigger come? A level that is crossed before there are enough samples is not the one that was meant; a fault is.
    fn watch(&mut self, drive: &Drive, samples: &Samples) {
        let enough = self.left == 0 && (!self.setup.inputs || self.course.now.is_some());
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
            let samples = if self.setup.inputs {
                self.setup.samples
            } else {
                self.ring.length.checked_div(self.ring.wide).unwrap_or(0) as u16
            };
            self.left = samples.saturating_sub(self.setup.before).max(1);
            // The trigger's own tick is the first one after it; a sample that was being read is dropped.
            self.ring.wait = 0;
            (self.state, self.changed) = (State::Recording, true);
        }
    }

    /// There is something to tell.
    #[inline]
    pub const fn has_answer(&self) -> bool {
        self.changed
    }

    /// What there is to tell. Ask only if it can be taken: it is told once.
    #[inline]
    pub fn poll(&mut self) -> Option<Answer<H>> {
        if !core::mem::take(&mut self.changed) {
            return None;
        }
        match self.state {
            State::Armed | State::Recording => Some(Answer::State(self.state)),
            // It is the keeper's again, who alone arms.
            State::Idle | State::Done => self.memory.take().map(|memory| Answer::Ended(self.state, memory)),
        }
    }
}
