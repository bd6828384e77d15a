//! Requests of either master from the call to the taken answer.

use super::error::NotTaken;
use heapless::Deque;

/// Requests that may wait, be under way, or be answered and not taken.
const CAPACITY: usize = 8;

/// Requests `R`, of which one is under way as `C`, and their answers `A` in the same order.
#[derive(Clone, Debug)]
pub(super) struct Waiting<R, C, A> {
    requests: Deque<R, CAPACITY>,
    pub(super) current: Option<C>,
    answers: Deque<A, CAPACITY>,
}

impl<R, C, A> Default for Waiting<R, C, A> {
    fn default() -> Self {
        Self { requests: Deque::new(), current: None, answers: Deque::new() }
    }
}

impl<R, C, A> Waiting<R, C, A> {
    /// One more, if its answer will have room.
    pub(super) fn push(&mut self, request: R) -> Result<(), NotTaken> {
        let taken = self.requests.len() + usize::from(self.current.is_some()) + self.answers.len();
        if taken >= CAPACITY {
            return Err(NotTaken::Full);
        }
        self.requests.push_back(request).map_err(|_| NotTaken::Full)
    }

    /// The next answer.
    pub(super) fn pop(&mut self) -> Option<A> {
        self.answers.pop_front()
    }

    /// The request to begin with when none is under way.
    pub(super) fn next(&mut self) -> Option<R> {
        self.requests.pop_front()
    }

    /// Whether none waits to begin.
    pub(super) fn is_empty(&self) -> bool {
        self.requests.is_empty()
    }

    /// The one under way has its answer.
    pub(super) fn finish(&mut self, answer: A) {
        self.current = None;
        // `push` has seen to the room.
        let _ = self.answers.push_back(answer);
    }
}
