//! Trouble on order, for the tests of the watchdog and of the self-tests: `--trouble WHAT --after TICKS`.

use super::{kept, pace};

/// Part of the drive that hangs or breaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// The control interrupt comes no more.
    NoControl,
    /// The control interrupt never ends.
    Control,
    /// The task that sends and receives frames.
    Can,
    /// The task that reads the slow inputs.
    Background,
    /// The task that serves the flash.
    Flash,
    /// A bit of the program flips.
    Program,
    /// The end of the stack is written.
    Stack,
}

impl Task {
    /// By its name as an argument.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "no-control" => Self::NoControl,
            "control" => Self::Control,
            "can" => Self::Can,
            "background" => Self::Background,
            "flash" => Self::Flash,
            "program" => Self::Program,
            "stack" => Self::Stack,
            _ => return None,
        })
    }
}

/// Trouble to be caused: the task, and the control tick from which on.
#[derive(Clone, Copy, Debug)]
pub struct Trouble {
    /// The task.
    pub task: Task,
    /// The tick.
    pub after: u64,
}

impl Trouble {
    /// Returns whether `task` is to be in trouble at this tick; from the first time on, the time that it
    /// hangs is counted.
    pub fn has(self, task: Task, tick: u64) -> bool {
        let hangs = self.task == task && tick >= self.after;
        if hangs {
            kept::begin_hanging();
        }
        hangs
    }

    /// Hangs, if it is the turn of `task`: in the control interrupt, which no other interrupts, the clock is
    /// looked after here.
    pub fn meet(self, task: Task, tick: u64) {
        if self.has(task, tick) {
            loop {
                if task == Task::Control {
                    pace::look_for_millisecond();
                }
            }
        }
    }
}
