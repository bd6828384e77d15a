//! The virtual scope as the bus sees it: LOG VIRTUAL SCOPE, parameters 22 to 26, 260 and 290 to 292.

use super::Node;
use super::requests::Refused;
use crate::bus::Frame;
use crate::bus::narmotion::FromDrive;
use crate::dictionary::{Parameters, number};
use crate::motor::signal::{ShaftScale, Signal};
use crate::scope::{Block, Refusal, SCOPE, ScopeReply, ScopeTask, Setup, State, Threshold, Trigger, period};
use crate::units::quotient;
use heapless::{Deque, Vec};
use serde::{Deserialize, Serialize};

/// Blocks that wait for the bus.
const BLOCKS: usize = 8;

/// The node's view of the scope.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct ScopeLink {
    /// State that the scope last reported, or that the waiting request leads to.
    state: State,
    request: Option<ScopeTask>,
    /// Arming was requested, and the scope has not answered yet.
    arms: bool,
    /// Address of the next block, while a download is under way.
    expected: Option<u16>,
    blocks: Deque<Block, BLOCKS>,
    /// Words of the record.
    words: u16,
    /// Words of the memory, once they are known.
    room: Option<u16>,
    /// Reason why the last request was refused.
    refusal: Refusal,
}

impl ScopeLink {
    /// State of the scope.
    pub(super) const fn state(&self) -> State {
        self.state
    }

    /// Words that can be downloaded.
    pub(super) const fn words(&self) -> u16 {
        self.words
    }

    /// Words that the memory holds.
    pub(super) fn room(&self) -> u16 {
        self.room.unwrap_or(0)
    }

    /// Reason why the last request was refused.
    pub(super) const fn refusal(&self) -> Refusal {
        self.refusal
    }

    /// Keeps the refusal of a request, or that there was none.
    fn note(&mut self, done: Result<(), Refusal>) -> Result<(), Refused> {
        self.refusal = done.err().unwrap_or_default();
        done.map_err(|_| Refused)
    }

    /// Arms the scope, or forces the trigger of an armed one.
    pub(super) fn trigger(&mut self, parameters: &Parameters, tick_rate: u32) -> Result<(), Refused> {
        let done = self.try_trigger(parameters, tick_rate);
        self.note(done)
    }

    fn try_trigger(&mut self, parameters: &Parameters, tick_rate: u32) -> Result<(), Refusal> {
        match self.state {
            State::Armed if self.request.is_none() => self.request = Some(ScopeTask::Force),
            State::Idle | State::Done => {
                let setup = setup(parameters, tick_rate).ok_or(Refusal::UnknownSignal)?;
                setup.refusal(self.room)?;
                self.request = Some(ScopeTask::Arm(setup));
                self.stop_download();
                (self.state, self.arms, self.words) = (State::Armed, true, 0);
            }
            State::Armed | State::Recording => return Err(Refusal::Busy),
        }
        Ok(())
    }

    /// Sends the record from its first word, whatever was sent of it before.
    pub(super) fn download(&mut self) -> Result<(), Refused> {
        let done = if self.state == State::Done { Ok(()) } else { Err(Refusal::NoRecord) };
        self.note(done)?;
        self.blocks.clear();
        (self.expected, self.request) = (Some(0), Some(ScopeTask::Read));
        Ok(())
    }

    /// Stops the download.
    fn stop_download(&mut self) {
        self.blocks.clear();
        self.expected = None;
    }

    /// Takes a report of the scope; returns true if it could not be armed. Blocks from before a restart of
    /// the download are not sent.
    fn take(&mut self, report: ScopeReply) -> bool {
        match report {
            ScopeReply::State(state, words) => {
                let refused = core::mem::take(&mut self.arms) && state == State::Idle;
                (self.state, self.words) = (state, words);
                if refused {
                    self.refusal = Refusal::NoMemory;
                }
                refused
            }
            ScopeReply::Room(room) => {
                self.room = Some(room);
                false
            }
            ScopeReply::Block(block) => {
                if self.expected == Some(block.address) && self.blocks.push_back(block).is_ok() {
                    self.expected = (!block.last).then_some(block.address.wrapping_add(3));
                }
                false
            }
        }
    }
}

impl PartialEq for ScopeLink {
    fn eq(&self, other: &Self) -> bool {
        (self.state, &self.request, self.arms, self.expected, self.words, self.room, self.refusal)
            == (
                other.state,
                &other.request,
                other.arms,
                other.expected,
                other.words,
                other.room,
                other.refusal,
            )
            && self.blocks.iter().eq(other.blocks.iter())
    }
}

impl Node {
    /// Returns whether there is room for another report of the scope. Without room the caller keeps the
    /// report.
    pub fn takes_scope_report(&self) -> bool {
        !self.scope.blocks.is_full()
    }

    /// Takes a report of the scope.
    pub fn handle_scope(&mut self, report: ScopeReply) {
        if self.scope.take(report) {
            self.count_refused();
        }
    }

    /// The next request to the scope.
    pub fn poll_scope(&mut self) -> Option<ScopeTask> {
        self.scope.request.take()
    }

    /// Returns the next frame of the download, if its block has arrived.
    pub(super) fn next_of_scope(&mut self) -> Option<Frame> {
        let Block { address, words, .. } = self.scope.blocks.pop_front().filter(|_| SCOPE)?;
        Some(FromDrive::ScopeData { address, data: words }.encode(self.addresses))
    }
}

/// Time from one sample to the next (parameter 25), us.
pub(super) fn sampling_time(parameters: &Parameters, tick_rate: u32) -> i32 {
    let signals = parameters.raw(number::SCOPE_CHANNELS).count_ones() as usize;
    let inputs = parameters.raw(number::SCOPE_INPUTS) != 0;
    let ticks = if inputs { 1 } else { period(signals, parameters.raw(number::SCOPE_PRESCALER) as u16) };
    quotient(i64::from(ticks) * 1_000_000, tick_rate.max(1).into()) as i32
}

/// Builds the setup from the parameters; `None` if a signal is not known.
fn setup(parameters: &Parameters, tick_rate: u32) -> Option<Setup> {
    let mut signals = Vec::new();
    let channels = parameters.raw(number::SCOPE_CHANNELS) as u32;
    let inputs = parameters.raw(number::SCOPE_INPUTS) != 0;
    for bit in (0..32).filter(|bit| channels >> bit & 1 == 1) {
        signals.push(Signal::of_bit(bit)?).ok()?;
    }
    let word = |number| parameters.raw(number) as u16;
    Some(Setup {
        signals,
        inputs,
        tick_rate,
        samples: word(number::SCOPE_SAMPLES),
        prescaler: word(number::SCOPE_PRESCALER),
        before: word(number::SCOPE_TRIGGER_PHASE),
        trigger: trigger(parameters)?,
        speed: ShaftScale::new(word(number::MOTOR_POLE_PAIRS)),
    })
}

fn trigger(parameters: &Parameters) -> Option<Trigger> {
    let threshold = |above| {
        let signal = Signal::of_bit(parameters.raw(number::SCOPE_TRIGGER_SIGNAL) as u8)?;
        // Thousandths of a base to 4096ths.
        let level = (parameters.raw(number::SCOPE_TRIGGER_LEVEL) * 4096 / 1000) as i16;
        Some(Threshold { signal, level, above })
    };
    Some(match parameters.raw(number::SCOPE_TRIGGER) {
        1 => Trigger::Level(threshold(true)?),
        2 => Trigger::Level(threshold(false)?),
        3 => Trigger::Edge(threshold(true)?),
        4 => Trigger::Edge(threshold(false)?),
        5 => Trigger::StateChange,
        6 => Trigger::Fault,
        _ => Trigger::Forced,
    })
}
