//! A virtual drive for everybody's tools: the bench in step with the clock on the wall, its bus as slcan over
//! TCP and a pseudo-terminal.
//!
//! ```text
//!   TCP client  <─> reader, writer ─┐             ┌─> arbitration ─> simulated bus <─> drive, plant
//!   TCP client  <─> reader, writer ─┼─> adapters ─┤                       │
//!   terminal    <─> reader, writer ─┘             └──── all but its sender ┘
//!      threads                              one thread, held back by `Pace`
//! ```

mod client;
mod hub;
mod pace;
#[cfg(unix)]
mod pty;
mod tcp;
#[cfg(test)]
mod tests;
pub mod tx_drivers;

pub use pace::Speed;

use client::Connection;
use hub::Hub;
use narx_sim::bench::Bench;
use pace::Pace;
use std::io;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;
use std::time::{Duration, Instant};

/// Time to sleep when simulated time has come as far as it may: a tenth of it is a control tick.
const SLEEP: Duration = Duration::from_millis(1);
/// Ticks between two looks at the clock and for new clients: 10 ms of simulated time.
const TICKS: u32 = 100;
/// From one summary to the next.
const TOLD: Duration = Duration::from_secs(1);

/// A bench with its doors. Whoever owns it calls [`step`](Self::step) until it is to end.
pub struct Server {
    hub: Hub,
    pace: Pace,
    end: u64,
    begun: Instant,
    told: Duration,
    door: Sender<Connection>,
    connections: Receiver<Connection>,
    /// The terminal's path is taken back when this ends.
    #[cfg(unix)]
    terminals: Vec<pty::Terminal>,
}

impl Server {
    /// Serves this bench until `end` ns of simulated time; it keeps no recording.
    pub fn new(bench: Bench, speed: Speed, end: u64) -> Self {
        let (door, connections) = mpsc::channel();
        Self {
            hub: Hub::new(bench.without_recording()),
            pace: Pace::new(speed),
            end,
            begun: Instant::now(),
            told: Duration::ZERO,
            door,
            connections,
            #[cfg(unix)]
            terminals: Vec::new(),
        }
    }

    /// Takes clients over TCP at this address, port 0 being any free one: the address that it really is.
    ///
    /// # Errors
    /// The address is taken, or not this machine's.
    pub fn listen(&mut self, address: SocketAddr) -> io::Result<SocketAddr> {
        tcp::listen(address, self.door.clone())
    }

    /// Takes clients over a pseudo-terminal, one after another: the path that they open. That is `link`, a
    /// symbolic link, if one is asked for.
    ///
    /// # Errors
    /// This system has none, or there is something else at `link`.
    #[cfg(unix)]
    pub fn open_terminal(&mut self, link: Option<&Path>) -> io::Result<PathBuf> {
        let (terminal, connection) = pty::open(link)?;
        let path = terminal.path().to_owned();
        self.terminals.push(terminal);
        self.hub.attach(connection);
        Ok(path)
    }

    /// Takes clients over a pseudo-terminal.
    ///
    /// # Errors
    /// This system has none.
    #[cfg(not(unix))]
    pub fn open_terminal(&mut self, _: Option<&Path>) -> io::Result<PathBuf> {
        Err(io::Error::other("this system has no pseudo-terminals"))
    }

    /// Simulates what is due, 10 ms at most, and sleeps a moment if nothing more is; false at the end.
    pub fn step(&mut self) -> bool {
        let hub = &mut self.hub;
        self.connections.try_iter().for_each(|connection| hub.attach(connection));
        let limits = self.pace.limits(self.begun.elapsed(), hub.now_ns(), hub.busy_ns());
        let mut left = TICKS;
        while left > 0 && hub.now_ns() < limits.time.min(self.end) && hub.busy_ns() < limits.busy {
            hub.step();
            left -= 1;
        }
        let goes_on = hub.now_ns() < self.end;
        if left > 0 && goes_on {
            thread::sleep(SLEEP);
        }
        goes_on
    }

    /// Lines for people since the last call: who came and went, and every second what the drive does.
    pub fn take_news(&mut self) -> Vec<String> {
        let mut news = self.hub.take_news();
        if self.begun.elapsed() >= self.told + TOLD {
            self.told += TOLD;
            let behind = self.pace.behind_ns(self.hub.now_ns()) as f64 / 1e6;
            news.push(format!("{}, {behind:.0} ms behind", self.hub.summary()));
        }
        news
    }
}

/// Returns the call with which a client of python-can opens a channel.
pub fn call(channel: &str) -> String {
    format!("can.Bus(interface=\"slcan\", channel=\"{channel}\", bitrate=500000)")
}
