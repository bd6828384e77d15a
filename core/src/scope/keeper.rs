//! The background's half of the scope: it keeps the memory while the other half has no use for it.

use super::memory::Memory;
use super::read::Reader;
use super::{Answer, Order, Report, Request, State};
use core::borrow::Borrow;

/// Stands between the node and the [`Scope`](super::Scope). `H` holds the memory.
#[derive(Clone, Debug)]
pub struct Keeper<H> {
    memory: Option<H>,
    /// The other half has it.
    lent: bool,
    order: Option<Order<H>>,
    /// What the scope does, until the node was told.
    state: Option<State>,
    reader: Option<Reader>,
}

impl<H> Default for Keeper<H> {
    fn default() -> Self {
        Self { memory: None, lent: false, order: None, state: None, reader: None }
    }
}

impl<H: Borrow<Memory>> Keeper<H> {
    /// Without a memory the scope cannot be armed.
    pub fn new(memory: H) -> Self {
        Self { memory: Some(memory), ..Self::default() }
    }

    /// Takes what the node asks for, once the order before was taken.
    pub fn handle(&mut self, request: Request) {
        match request {
            Request::Arm(setup) => {
                // One that is armed, or has no memory, cannot be.
                self.reader = None;
                match self.memory.take() {
                    Some(memory) => (self.lent, self.order) = (true, Some(Order::Arm(setup, memory))),
                    None if self.lent => {}
                    None => self.state = Some(State::Idle),
                }
            }
            Request::Force => self.order = Some(Order::Force),
            Request::Read => self.reader = self.memory.as_ref().map(|memory| Reader::new(memory.borrow())),
        }
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
        match answer {
            Answer::State(state) => self.state = Some(state),
            Answer::Ended(state, memory) => {
                (self.state, self.memory, self.lent) = (Some(state), Some(memory), false);
            }
        }
    }

    /// What the node has to hear. Ask only if it takes it.
    pub fn poll_report(&mut self) -> Option<Report> {
        let memory = self.memory.as_ref().map(Borrow::borrow);
        if let Some(state) = self.state.take() {
            return Some(Report::State(state, memory.map_or(0, |memory| Reader::new(memory).words())));
        }
        let (memory, reader) = (memory?, self.reader.as_mut()?);
        let block = reader.next(memory);
        if block.is_none_or(|block| block.last) {
            self.reader = None;
        }
        block.map(Report::Block)
    }
}
