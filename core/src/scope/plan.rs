//! A set-up as the control tick follows it: the background computes in advance whatever it can.

use super::RECORDER;
use super::memory::Memory;
use super::setup::{SIGNALS_A_TICK, Setup, Threshold, Trigger};
use crate::motor::signal::{DRIVE_SIGNALS, ShaftScale, Signal};
use heapless::Vec;

#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// The signals of a sample.
    pub(super) signals: Vec<Signal, { DRIVE_SIGNALS.len() }>,
    inputs: bool,
    pub(super) tick_rate: u32,
    /// Words of a record of signals.
    pub(super) length: usize,
    /// Samples from before the trigger, and from it on.
    pub(super) before: u16,
    pub(super) after: u16,
    /// Ticks between a complete sample and the next one, and the number of signals that count as read
    /// meanwhile.
    pub(super) pause: u16,
    pub(super) rest: u8,
    pub(super) watch: Watch,
    pub(super) speed: ShaftScale,
}

impl Plan {
    /// A plan that records nothing.
    pub(super) const fn new() -> Self {
        Self {
            signals: Vec::new(),
            inputs: false,
            tick_rate: 0,
            length: 0,
            before: 0,
            after: 0,
            pause: 0,
            rest: 0,
            watch: Watch::Nothing,
            speed: ShaftScale::new(1),
        }
    }

    /// Returns whether inputs are recorded, not signals.
    #[inline]
    pub(super) const fn keeps_inputs(&self) -> bool {
        RECORDER && self.inputs
    }

    /// Plan of a set-up; `None` if `memory` has no room for all samples of its signals, or for any inputs.
    pub(super) fn of(setup: &Setup, memory: &Memory) -> Option<Self> {
        let Setup { inputs, tick_rate, speed, .. } = *setup;
        let wide = setup.signals.len();
        let samples = if inputs {
            (RECORDER && memory.half() > 0).then_some(setup.samples)?
        } else {
            setup.fits(memory.room()).then_some(setup.samples)?
        };
        let pause = setup.period().saturating_sub(wide.div_ceil(SIGNALS_A_TICK) as u16);
        let before = setup.before.min(samples.saturating_sub(1));
        Some(Self {
            signals: setup.signals.clone(),
            inputs,
            tick_rate,
            length: wide * usize::from(samples),
            before,
            after: (samples - before).max(1),
            pause,
            rest: if pause == 0 { 0 } else { wide as u8 },
            watch: Watch::of(setup.trigger),
            speed,
        })
    }
}

/// Condition to watch for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Watch {
    Nothing,
    /// A sample that exceeds `level` after an exclusive or with `flip`: one comparison serves both sides.
    Sample {
        signal: Signal,
        flip: i32,
        level: i32,
        edge: bool,
    },
    Change,
    Fault,
}

impl Watch {
    const fn of(trigger: Trigger) -> Self {
        let (Threshold { signal, level, above }, edge) = match trigger {
            Trigger::Forced => return Self::Nothing,
            Trigger::StateChange => return Self::Change,
            Trigger::Fault => return Self::Fault,
            Trigger::Level(threshold) => (threshold, false),
            Trigger::Edge(threshold) => (threshold, true),
        };
        let flip = if above { 0 } else { -1 };
        Self::Sample { signal, flip, level: level as i32 ^ flip, edge }
    }
}
