//! The control tick's half of the scope.
//!
//! ```text
//!             arm          trigger                  full
//!   Idle ----------> Armed ----------> Recording ----------> Done     "before" samples are kept from
//!                      |<-- before -->|<---- the rest ---->|          before the trigger
//! ```
//!
//! Samples of signals are written to a ring. Inputs fill the two halves of the memory in turn, each after a
//! checkpoint of the drive: so at any time one half is complete, and the other partly filled.

use super::inputs::{self, Before, Note};
use super::memory::{Course, Half, Memory, PATIENCE, Phase, Progress};
use super::plan::Watch;
use super::setup::SIGNALS_A_TICK;
use super::{Answer, Order, SCOPE, State};
use crate::motor::signal::{ShaftScale, Signal};
use crate::motor::{Drive, Event, Samples};
use core::borrow::BorrowMut;

/// The control tick's half of the scope, which fills the memory. `H` holds the memory: a reference, or a box.
#[derive(Clone, Debug)]
pub struct Scope<H> {
    /// `None` while this is idle: the keeper has the memory then.
    memory: Option<H>,
}

/// Words left in a half when the change to the other half begins to wait for a calm tick.
const NEAR: usize = inputs::WORDS_MAX + 64;

impl<H> Default for Scope<H> {
    fn default() -> Self {
        Self { memory: None }
    }
}

impl<H: BorrowMut<Memory>> Scope<H> {
    #[inline]
    fn memory(&mut self) -> Option<&mut Memory> {
        if SCOPE { self.memory.as_mut().map(BorrowMut::borrow_mut) } else { None }
    }

    /// State of the scope; idle without a memory, whether a record is done or not.
    pub fn state(&self) -> State {
        self.memory.as_ref().map_or(State::Idle, |memory| match memory.borrow().progress.phase {
            Phase::Watching | Phase::Fired => State::Armed,
            Phase::Recording => State::Recording,
            Phase::Done => State::Done,
        })
    }

    /// The memory, if the scope has it.
    pub fn into_memory(self) -> Option<H> {
        self.memory
    }

    /// Takes an order. The keeper ensures that it fits the state.
    #[inline]
    pub fn handle(&mut self, order: Order<H>) {
        match order {
            Order::Arm(memory) => self.memory = Some(memory),
            Order::Force => {
                if let Some(memory) = self.memory() {
                    memory.progress.force();
                }
            }
        }
    }

    /// Takes the event of this tick, before the drive takes it.
    #[inline]
    pub fn handle_event(&mut self, event: &Event) {
        if let Some(memory) = self.memory()
            && memory.plan.keeps_inputs()
        {
            memory.progress.course.note = Note::from(event);
        }
    }

    /// Runs one control tick, after the drive's and after its status was polled.
    #[inline]
    pub fn step(&mut self, drive: &Drive, samples: &Samples) {
        if let Some(memory) = self.memory() {
            memory.step(drive, samples);
        }
    }

    /// Returns whether there is an answer.
    #[inline]
    pub fn has_answer(&self) -> bool {
        SCOPE && self.memory.as_ref().is_some_and(|memory| memory.borrow().progress.changed)
    }

    /// Takes the answer. Call only if it can be passed on: it is returned once.
    #[inline]
    pub fn poll(&mut self) -> Option<Answer<H>> {
        let progress = &mut self.memory()?.progress;
        if !core::mem::take(&mut progress.changed) {
            return None;
        }
        match progress.phase {
            // The memory goes back to the keeper, which alone arms.
            Phase::Done => self.memory.take().map(Answer::Done),
            _ => Some(Answer::Triggered),
        }
    }
}

impl Memory {
    /// One control tick.
    #[inline(never)]
    fn step(&mut self, drive: &Drive, samples: &Samples) {
        match self.progress.phase {
            Phase::Watching => self.watch(drive, samples),
            Phase::Fired => self.start(),
            Phase::Recording => {}
            Phase::Done => return,
        }
        if self.plan.keeps_inputs() {
            self.record_inputs(drive, samples);
        } else {
            self.record_signals(drive, samples);
        }
    }

    /// Counters are updated before the signals are read, so that nothing else has to be kept during the
    /// reading.
    #[inline]
    fn record_signals(&mut self, drive: &Drive, samples: &Samples) {
        let (plan, ring) = (&self.plan, &mut self.progress.ring);
        let (wide, read, begin) = (plan.signals.len(), usize::from(ring.read), usize::from(ring.place));
        if read >= wide {
            ring.waited = ring.waited.saturating_add(1);
            if ring.waited >= plan.pause {
                (ring.read, ring.waited) = (0, 0);
            }
            return;
        }
        let (next, place) = (read + SIGNALS_A_TICK, begin + read);
        if next < wide {
            ring.read = next as u8;
        } else {
            let end = begin + wide;
            ring.place = if end >= plan.length { 0 } else { end as u16 };
            ring.read = plan.rest;
            self.count();
        }
        let plan = &self.plan;
        let signals = plan.signals.get(read..next).and_then(|signals| signals.first_chunk());
        let words =
            self.words.get_mut(place..place + SIGNALS_A_TICK).and_then(|words| words.first_chunk_mut());
        if let (Some(signals), Some(words)) = (signals, words) {
            drive.sample4(signals, plan.speed, samples, words);
        } else {
            let words = self.words.get_mut(place..).unwrap_or_default();
            sample_few(drive, plan.signals.get(read..).unwrap_or_default(), plan.speed, samples, words);
        }
    }

    /// Counts a complete sample.
    #[inline]
    fn count(&mut self) {
        let Some(left) = self.progress.left.checked_sub(1) else { return };
        self.progress.left = left;
        if left == 0 && self.progress.phase == Phase::Recording {
            self.end();
        }
    }

    /// Ends a full record; the background finds out its content ([`Memory::close`]).
    #[cold]
    #[inline(never)]
    fn end(&mut self) {
        (self.progress.phase, self.progress.changed) = (Phase::Done, true);
    }

    #[inline(never)]
    fn record_inputs(&mut self, drive: &Drive, samples: &Samples) {
        let half = self.half();
        let course = &mut self.progress.course;
        let note = core::mem::take(&mut course.note);
        let Some(now) = course.now.as_mut().filter(|_| note != Note::Checkpoint) else {
            return self.begin_anew(note, drive, samples);
        };
        let begin = usize::from(now.place) * half + usize::from(now.words);
        let room = self.words.get_mut(begin..).unwrap_or_default();
        now.words += inputs::write(room, note, samples, &mut course.before) as u16;
        now.ticks += 1;
        let left = half.saturating_sub(now.words.into());
        self.count();
        if left < NEAR
            && (left < inputs::WORDS_MAX || drive.has_time_to_spare())
            && self.progress.phase != Phase::Done
        {
            self.turn_over(drive, samples);
        }
    }

    /// Begins anew, or ends the recording: there is no half to be filled yet, or the event cannot be kept, so
    /// the inputs so far do not lead to the present state.
    #[cold]
    fn begin_anew(&mut self, note: Note, drive: &Drive, samples: &Samples) {
        if self.progress.phase == Phase::Recording {
            return self.end();
        }
        let course = &mut self.progress.course;
        if course.now.take().is_some() || note == Note::Checkpoint {
            (course.older, course.patience) = (None, PATIENCE);
            self.progress.left = 1;
        }
        match course.patience.checked_sub(1) {
            Some(left) if !drive.has_time_to_spare() => course.patience = left,
            _ => self.begin_half(0, drive, samples),
        }
    }

    /// Goes on to the other half when one is full, or ends the record.
    #[cold]
    fn turn_over(&mut self, drive: &Drive, samples: &Samples) {
        let course = &mut self.progress.course;
        if course.keeps {
            return self.end();
        }
        course.keeps = self.progress.phase == Phase::Recording;
        course.older = course.now;
        let place = course.now.map_or(0, |half| half.place ^ 1);
        self.begin_half(place, drive, samples);
    }

    fn begin_half(&mut self, place: u8, drive: &Drive, samples: &Samples) {
        if let Some(checkpoint) = self.checkpoints.get_mut(usize::from(place)) {
            *checkpoint = Some(drive.clone());
        }
        if self.progress.phase != Phase::Recording {
            self.progress.left = 0;
        }
        let Course { now, before, .. } = &mut self.progress.course;
        *now = Some(Half { place, first: samples.tick.wrapping_add(1), ticks: 0, words: 0 });
        *before = Before { tick: samples.tick, ..Before::START };
    }

    /// Watches for the trigger. A level that is crossed before there are enough samples does not count; a
    /// change of state or a fault does.
    #[inline]
    fn watch(&mut self, drive: &Drive, samples: &Samples) {
        let (plan, before) = (&self.plan, &mut self.progress.before);
        if let Watch::Sample { signal, flip, level, edge } = &plan.watch {
            if (drive.sample(*signal, plan.speed, samples) ^ flip) > *level {
                let held = core::mem::replace(&mut before.holds, true);
                if !(held && *edge) && self.progress.left == 0 {
                    self.start();
                }
            } else {
                before.holds = false;
            }
        } else if self.changes(drive) {
            self.start();
        }
    }

    /// Returns whether the state has changed, or a fault is new, as watched.
    #[inline(never)]
    fn changes(&mut self, drive: &Drive) -> bool {
        let before = &mut self.progress.before;
        let (state, faults) = (drive.state(), drive.faults().bits());
        let came = match self.plan.watch {
            Watch::Change => state != before.state,
            Watch::Fault => faults & !before.faults != 0,
            Watch::Nothing | Watch::Sample { .. } => false,
        };
        // The first call only learns the present values.
        let learns = before.faults == u32::MAX;
        (before.state, before.faults) = (state, faults);
        came && !learns
    }

    /// Takes the trigger. It counts once there are enough samples from before it.
    #[inline]
    const fn start(&mut self) {
        let Progress { phase, changed, left, ring, .. } = &mut self.progress;
        if *left > 0 {
            *phase = Phase::Fired;
            return;
        }
        (*phase, *changed, *left) = (Phase::Recording, true, self.plan.after);
        // The trigger's own tick is the first one after it; a sample that was being read is dropped.
        (ring.read, ring.waited) = (0, 0);
    }
}

impl Progress {
    /// Acts as if the trigger had come.
    const fn force(&mut self) {
        if let Phase::Watching = self.phase {
            self.phase = Phase::Fired;
        }
    }
}

/// Reads fewer signals than a tick has time for.
#[inline(never)]
fn sample_few(drive: &Drive, signals: &[Signal], speed: ShaftScale, samples: &Samples, words: &mut [u16]) {
    for (word, signal) in words.iter_mut().zip(signals) {
        *word = drive.sample(*signal, speed, samples) as u16;
    }
}
