//! A session that the bench and its masters share. It runs without Python's lock, so that other threads
//! continue.

use crate::tx_master::Station;
use narx_sim::session::Session;
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// A session with several owners.
#[derive(Clone)]
pub(crate) struct Shared(Arc<Mutex<Table>>);

/// The session, and the other masters on its bus.
struct Table {
    session: Session,
    /// Largest temperature of the winding so far, degrees Celsius, and its time, s.
    hottest: (f64, f64),
    /// Masters of TX-Drivers that are still in use.
    stations: Vec<Weak<Mutex<Station>>>,
}

/// Ticks between two checks of Python's signals, some 10 ms of work, so that Ctrl-C ends a long run.
const CHUNK: u64 = 1000;

impl Shared {
    pub(crate) fn new(session: Session) -> Self {
        let hottest = temperature(&session);
        Self(Arc::new(Mutex::new(Table { session, hottest, stations: Vec::new() })))
    }

    /// Returns a copy of the session as it stands. Masters of TX-Drivers stay with this one.
    pub(crate) fn copy(&self, py: Python<'_>) -> Self {
        self.with_table(py, |table| {
            let Table { session, hottest, .. } = table;
            Self(Arc::new(Mutex::new(Table {
                session: session.clone(),
                hottest: *hottest,
                stations: Vec::new(),
            })))
        })
    }

    /// Returns the largest temperature of the winding so far, degrees Celsius, and its time, s.
    pub(crate) fn hottest(&self, py: Python<'_>) -> (f64, f64) {
        self.with_table(py, |table| table.hottest)
    }

    /// Adds a master at the host's place on the bus; it receives frames from now on.
    pub(crate) fn seat(&self, py: Python<'_>, station: &Arc<Mutex<Station>>) {
        let station = Arc::downgrade(station);
        self.with_table(py, |table| {
            while table.session.bench_mut().monitor().is_some() {}
            table.stations.push(station);
        });
    }

    /// Calls `act` with the session, once it is free.
    pub(crate) fn with<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&mut Session) -> T + Send) -> T {
        self.with_table(py, |table| act(&mut table.session))
    }

    /// Runs this many control ticks.
    pub(crate) fn run(&self, py: Python<'_>, ticks: u64) -> PyResult<()> {
        let mut left = ticks;
        while left > 0 {
            let chunk = left.min(CHUNK);
            self.with_table(py, |table| {
                (0..chunk).for_each(|_| table.step());
                let now = temperature(&table.session);
                if now.0 > table.hottest.0 {
                    table.hottest = now;
                }
            });
            left -= chunk;
            py.check_signals()?;
        }
        Ok(())
    }

    fn with_table<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&mut Table) -> T + Send) -> T {
        // A thread that waits for the session must not hold Python's lock: the session's owner may need that
        // lock to finish.
        py.detach(|| act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

/// Returns the temperature of the winding now, degrees Celsius, and the time, s.
fn temperature(session: &Session) -> (f64, f64) {
    let seen = session.bench().plant().observe();
    (seen.winding_temperature, seen.time)
}

impl Table {
    /// Runs one control tick, with the frames of all masters.
    fn step(&mut self) {
        if self.stations.is_empty() {
            return self.session.step();
        }
        self.stations.retain(|station| station.strong_count() > 0);
        let now = self.session.bench().now_ns() / 1000;
        self.each(|station, session| {
            while let Some(frame) = station.poll_frame(now) {
                // It cannot fail: a few commands and one request at a time do not fill a queue of 64.
                let _ = session.bench_mut().send(frame);
            }
        });
        self.session.step();
        while let Some(received) = self.session.bench_mut().monitor() {
            self.each(|station, _| station.handle_frame(&received.frame, received.time_ns / 1000));
        }
    }

    fn each(&mut self, mut act: impl FnMut(&mut Station, &mut Session)) {
        for station in self.stations.iter().filter_map(Weak::upgrade) {
            act(&mut station.lock().unwrap_or_else(PoisonError::into_inner), &mut self.session);
        }
    }
}
