//! Queue of requests of either master, from the call until the answer is taken.

use super::error::NotTaken;
use heapless::Deque;

/// Largest number of requests that wait, are under way, or are answered but not taken yet.
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
    /// Queues a request, if its answer will have room.
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

    /// Takes the next request from the queue, when none is under way.
    pub(super) fn next(&mut self) -> Option<R> {
        self.requests.pop_front()
    }

    /// Returns whether no request waits to begin.
    pub(super) fn is_empty(&self) -> bool {
        self.requests.is_empty()
    }

    /// Ends the request under way with its answer.
    pub(super) fn finish(&mut self, answer: A) {
        self.current = None;
        // There is room: `push` has checked it.
        let _ = self.answers.push_back(answer);
    }
}
