//! The scope's memory on the heap. A copy of the bench gets one of its own.

use alloc::boxed::Box;
use core::borrow::{Borrow, BorrowMut};
use narx_core::scope::{Memory, WORDS};

#[derive(Clone, Debug)]
pub(super) struct ScopeMemory(Box<Memory<[u16; WORDS]>>);

impl ScopeMemory {
    pub(super) fn new() -> Self {
        Self(Box::new(Memory::<[u16; WORDS]>::new()))
    }
}

impl Borrow<Memory> for ScopeMemory {
    fn borrow(&self) -> &Memory {
        &*self.0
    }
}

impl BorrowMut<Memory> for ScopeMemory {
    fn borrow_mut(&mut self) -> &mut Memory {
        &mut *self.0
    }
}
