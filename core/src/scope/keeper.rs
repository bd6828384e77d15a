//! The background's half of the scope: it keeps the memory while the control tick's half does not need it.

use super::memory::Memory;
use super::{Answer, Order, SCOPE, ScopeReply, ScopeTask, Setup, State};
use core::borrow::BorrowMut;

/// Stands between the node and the [`Scope`](super::Scope). `H` holds the memory.
#[derive(Clone, Debug)]
pub struct Keeper<H> {
    memory: Option<H>,
    /// The control tick's half has the memory.
    lent: bool,
    order: Option<Order<H>>,
    /// State of the scope, and whether it has been reported to the node.
    state: State,
    told: bool,
    /// Words of the memory, until they have been reported to the node.
    room: Option<u16>,
}

impl<H> Default for Keeper<H> {
    fn default() -> Self {
        Self { memory: None, lent: false, order: None, state: State::Idle, told: true, room: None }
    }
}

impl<H: BorrowMut<Memory>> Keeper<H> {
    /// A keeper with this memory. The default one has none: its scope cannot be armed.
    pub fn new(memory: H) -> Self {
        let room = SCOPE.then(|| memory.borrow().room() as u16);
        Self { memory: Some(memory), room, ..Self::default() }
    }

    fn memory(&mut self) -> Option<&mut Memory> {
        if SCOPE { self.memory.as_mut().map(BorrowMut::borrow_mut) } else { None }
    }

    /// Takes a request of the node, once the order before was taken.
    pub fn handle(&mut self, request: ScopeTask) {
        match request {
            ScopeTask::Arm(setup) => {
                // An armed scope cannot be armed again.
                if !self.lent {
                    self.arm(&setup);
                }
            }
            ScopeTask::Force => self.order = Some(Order::Force),
            ScopeTask::Read => {
                if let Some(memory) = self.memory() {
                    memory.read();
                }
            }
        }
    }

    /// Arms the scope; without room for a record it stays idle.
    fn arm(&mut self, setup: &Setup) {
        self.lent = self.memory().is_some_and(|memory| memory.begin(setup));
        if self.lent {
            self.order = self.memory.take().map(Order::Arm);
        }
        (self.state, self.told) = (if self.lent { State::Armed } else { State::Idle }, false);
    }

    /// State of the scope, as last reported here.
    pub const fn state(&self) -> State {
        self.state
    }

    /// Returns whether there is an order for the control tick's half.
    pub const fn has_order(&self) -> bool {
        self.order.is_some()
    }

    /// Takes the order. Call only if it can be handed over.
    pub fn poll_order(&mut self) -> Option<Order<H>> {
        self.order.take()
    }

    /// Takes an answer of the control tick's half.
    pub fn take(&mut self, answer: Answer<H>) {
        self.told = false;
        self.state = match answer {
            Answer::Triggered => State::Recording,
            Answer::Done(mut memory) => {
                memory.borrow_mut().close();
                (self.memory, self.lent) = (Some(memory), false);
                State::Done
            }
        };
    }

    /// Takes the next report for the node. Call only if the node can take it.
    pub fn poll_report(&mut self) -> Option<ScopeReply> {
        if let Some(room) = self.room.take() {
            return Some(ScopeReply::Room(room));
        }
        if !self.told {
            self.told = true;
            return Some(ScopeReply::State(
                self.state,
                self.memory().map_or(0, |memory| memory.record_words()),
            ));
        }
        self.memory()?.next().map(ScopeReply::Block)
    }
}
