//! A session that the bench and its master share. It runs without Python's lock, so that other threads go on.

use narx_sim::session::Session;
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// A session with several owners.
#[derive(Clone)]
pub(crate) struct Shared(Arc<Mutex<Session>>);

/// Ticks between two looks at Python's signals, so that Ctrl-C ends a long run: some 10 ms of work.
const CHUNK: u64 = 1000;

impl Shared {
    pub(crate) fn new(session: Session) -> Self {
        Self(Arc::new(Mutex::new(session)))
    }

    /// Does something to the session, once nobody else does.
    pub(crate) fn with<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&mut Session) -> T + Send) -> T {
        // Whoever waits for the session must not hold Python's lock: its owner may need that to end.
        py.detach(|| act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    /// Runs so many control ticks.
    pub(crate) fn run(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        let mut left = ticks;
        while left > 0 {
            let chunk = left.min(CHUNK);
            self.with(py, |session| (0..chunk).for_each(|_| session.step()));
            left -= chunk;
            py.check_signals()?;
        }
        Ok(())
    }
}
