//! The background's half of the scope: it keeps the memory while the other half has no use for it.

use super::memory::Memory;
use super::{Answer, Order, Report, Request, SCOPE, Setup, State};
use core::borrow::BorrowMut;

/// Stands between the node and the [`Scope`](super::Scope). `H` holds the memory.
#[derive(Clone, Debug)]
pub struct Keeper<H> {
    memory: Option<H>,
    /// The other half has it.
    lent: bool,
    order: Option<Order<H>>,
    /// What the scope does, and whether the node has been told.
    state: State,
    told: bool,
    /// Words of the memory, until the node has been told.
    room: Option<u16>,
}

impl<H> Default for Keeper<H> {
    fn default() -> Self {
        Self { memory: None, lent: false, order: None, state: State::Idle, told: true, room: None }
    }
}

impl<H: BorrowMut<Memory>> Keeper<H> {
    /// Without a memory the scope cannot be armed.
    pub fn new(memory: H) -> Self {
        let room = SCOPE.then(|| memory.borrow().room() as u16);
        Self { memory: Some(memory), room, ..Self::default() }
    }

    fn memory(&mut self) -> Option<&mut Memory> {
        if SCOPE { self.memory.as_mut().map(BorrowMut::borrow_mut) } else { None }
    }

    /// Takes what the node asks for, once the order before was taken.
    pub fn handle(&mut self, request: Request) {
        match request {
            Request::Arm(setup) => {
                // One that is armed cannot be.
                if !self.lent {
                    self.arm(&setup);
                }
            }
            Request::Force => self.order = Some(Order::Force),
            Request::Read => {
                if let Some(memory) = self.memory() {
                    memory.read();
                }
            }
        }
    }

    /// Without room for a record the scope stays idle.
    fn arm(&mut self, setup: &Setup) {
        self.lent = self.memory().is_some_and(|memory| memory.begin(setup));
        if self.lent {
            self.order = self.memory.take().map(Order::Arm);
        }
        (self.state, self.told) = (if self.lent { State::Armed } else { State::Idle }, false);
    }

    /// What the scope does, as far as it was told here.
    pub const fn state(&self) -> State {
        self.state
    }

    /// There is an order for the control tick's half.
    pub const fn has_order(&self) -> bool {
        self.order.is_some()
    }

    /// The order. Ask only if it can be handed over.
    pub fn poll_order(&mut self) -> Option<Order<H>> {
        self.order.take()
    }

    /// Takes what the control tick's half says.
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

    /// What the node has to hear. Ask only if it takes it.
    pub fn poll_report(&mut self) -> Option<Report> {
        if let Some(room) = self.room.take() {
            return Some(Report::Room(room));
        }
        if !self.told {
            self.told = true;
            return Some(Report::State(self.state, self.memory().map_or(0, |memory| memory.record_words())));
        }
        self.memory()?.next().map(Report::Block)
    }
}
