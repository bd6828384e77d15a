//! The simulated bus with its clients: who sends next, and who receives it.

use super::client::{Client, Connection};
use narx_sim::bench::Bench;
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Frames of the clients in the controller that they share: one on the bus, and one to follow it without a
/// gap. So a more urgent frame of another client waits for one that came before it, never for more.
const IN_CONTROLLER: usize = 2;

/// A bench and its clients.
pub(super) struct Hub {
    bench: Bench,
    clients: Vec<(u64, Client)>,
    /// Whose frames are in the controller, in their order.
    sent: VecDeque<u64>,
    /// Frames of all clients so far.
    order: u64,
    attached: u64,
    news: Vec<String>,
}

impl Hub {
    pub(super) const fn new(bench: Bench) -> Self {
        Self { bench, clients: Vec::new(), sent: VecDeque::new(), order: 0, attached: 0, news: Vec::new() }
    }

    /// One more client. Like any adapter its channel is closed until it opens it.
    pub(super) fn attach(&mut self, connection: Connection) {
        self.attached += 1;
        self.news.push(format!("{} came", connection.name));
        self.clients.push((self.attached, Client::new(connection)));
    }

    /// One control tick.
    pub(super) fn step(&mut self) {
        for (_, client) in &mut self.clients {
            client.listen(&mut self.order);
        }
        self.arbitrate();
        self.bench.step();
        // The host is nobody: its clients monitor.
        while self.bench.receive().is_some() {}
        while let Some(received) = self.bench.monitor() {
            let sender = if received.sender == self.bench.host() { self.sent.pop_front() } else { None };
            for (id, client) in &mut self.clients {
                if Some(*id) != sender {
                    client.receive(&received.frame, received.time_ns / 1_000_000);
                }
            }
        }
        self.part();
    }

    /// The controller gets the most urgent of the clients' frames; on the bus it competes with the drive.
    fn arbitrate(&mut self) {
        while self.sent.len() < IN_CONTROLLER {
            let next = self.clients.iter_mut().filter_map(|client| Some((client.1.wants()?, client)));
            let Some((_, (id, client))) = next.min_by_key(|(wants, _)| *wants) else { return };
            if let Some(frame) = client.next()
                && self.bench.send(frame).is_ok()
            {
                self.sent.push_back(*id);
            }
        }
    }

    /// Forgets who has left.
    fn part(&mut self) {
        if !self.clients.iter().any(|(_, client)| client.is_finished()) {
            return;
        }
        for (_, client) in self.clients.extract_if(.., |(_, client)| client.is_finished()) {
            let dropped = client.dropped();
            let (lines, frames) = (dropped.lines, dropped.frames);
            self.news.push(format!(
                "{} left: {lines} lines to it and {frames} frames of it dropped",
                client.name()
            ));
        }
    }

    pub(super) fn now_ns(&self) -> u64 {
        self.bench.now_ns()
    }

    /// Time that the bus was busy, ns.
    pub(super) fn busy_ns(&self) -> u64 {
        self.bench.bus_statistics().busy_ns
    }

    /// Returns the news since the last call: clients that came and left.
    pub(super) fn take_news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.news)
    }

    /// A line about the drive and its clients.
    pub(super) fn summary(&self) -> String {
        let status = self.bench.status();
        let (state, rpm) = (status.state, self.bench.plant().observe().speed * 60.0 / TAU);
        let (time, clients) = (self.bench.time(), self.clients.len());
        let faults = status.faults.bits();
        let dropped: u64 = self.clients.iter().map(|(_, client)| client.dropped().lines).sum();
        format!(
            "{time:.1} s  {} {}, {rpm:.0} rpm, faults {faults:08X}, {clients} connected, {dropped} lines dropped",
            state as u8,
            state.name()
        )
    }
}
