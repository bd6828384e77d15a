//! Drive and node joined by queues: what a shell links, its control interrupt one half, its background the other.
//!
//! ```text
//!   Samples -> ControlTick -> PwmCommand          the interrupt: never waits, never blocks
//!                ^      |
//!          Event |      | Status                  single producer, single consumer each; a scope's
//!                |      v                         requests and reports likewise
//!    frames <-> Background                        the loop
//! ```
//!
//! Either half may interrupt the other at any instant: nothing but the queues is shared.

use crate::dictionary::Parameters;
use crate::motor::{Board, Coefficients, Drive, Event, PwmCommand, Samples, Status};
use crate::node::{Identity, Node};
use crate::scope::{Report, Request, Scope};
use heapless::spsc::{Consumer, Producer, Queue};

/// Room of a queue, one of which stays free.
const EVENTS: usize = 3;
const STATUSES: usize = 5;
const REQUESTS: usize = 2;
const REPORTS: usize = 9;

/// The queues between the halves of one device.
#[derive(Debug, Default)]
pub struct Queues {
    events: Queue<Event, EVENTS>,
    statuses: Queue<Status, STATUSES>,
    requests: Queue<Request, REQUESTS>,
    reports: Queue<Report, REPORTS>,
}

impl Queues {
    /// Empty queues.
    pub const fn new() -> Self {
        Self { events: Queue::new(), statuses: Queue::new(), requests: Queue::new(), reports: Queue::new() }
    }

    /// A device at power-up with a stored parameter set. One that does not build leaves the drive with none: the node
    /// says so, and it refuses to start.
    pub fn power_up(
        &mut self,
        identity: Identity,
        board: Board,
        parameters: Parameters,
    ) -> (ControlTick<'_>, Background<'_>) {
        // What waits from before a reboot belongs to nobody.
        *self = Self::new();
        let drive = Drive::new(Coefficients::build(&parameters, &board).unwrap_or_default());
        let node = Node::with_parameters(identity, board, parameters);
        let (events_in, events) = self.events.split();
        let (statuses, statuses_out) = self.statuses.split();
        let (requests_in, requests) = self.requests.split();
        let (reports, reports_out) = self.reports.split();
        let mut background = Background {
            node,
            events: events_in,
            statuses: statuses_out,
            requests: requests_in,
            reports: reports_out,
        };
        background.hand_over();
        let scope = Scope::new(Default::default());
        (ControlTick { drive, events, statuses, unsent: None, scope, requests, reports }, background)
    }
}

/// The half of the control interrupt.
pub struct ControlTick<'q> {
    drive: Drive,
    events: Consumer<'q, Event>,
    statuses: Producer<'q, Status>,
    /// The newest report, while the background is late.
    unsent: Option<Status>,
    scope: Scope<&'q mut [u16]>,
    requests: Consumer<'q, Request>,
    reports: Producer<'q, Report>,
}

impl<'q> ControlTick<'q> {
    /// Gives the virtual scope its memory, [`scope::WORDS`](crate::scope::WORDS) or fewer. Without any it cannot be armed.
    pub fn attach_scope(&mut self, memory: &'q mut [u16]) {
        self.scope = Scope::new(memory);
    }

    /// One control tick: takes at most one event, and reports if a report is due.
    pub fn step(&mut self, samples: &Samples) -> PwmCommand {
        if let Some(event) = self.events.dequeue() {
            self.drive.handle_event(event);
        }
        let command = self.drive.step(samples);
        if let Some(request) = self.requests.dequeue() {
            self.scope.handle(request);
        }
        self.scope.step(&self.drive, samples);
        if self.scope.has_report()
            && self.reports.ready()
            && let Some(report) = self.scope.poll()
        {
            // Room was just seen, and nobody else fills it.
            let _ = self.reports.enqueue(report);
        }
        self.unsent = self.drive.poll_status().or(self.unsent);
        if let Some(status) = self.unsent.take() {
            self.unsent = self.statuses.enqueue(status).err();
        }
        command
    }

    /// The drive, to look at.
    pub const fn drive(&self) -> &Drive {
        &self.drive
    }
}

/// The half of the background loop.
pub struct Background<'q> {
    node: Node,
    events: Producer<'q, Event>,
    statuses: Consumer<'q, Status>,
    requests: Producer<'q, Request>,
    reports: Consumer<'q, Report>,
}

impl Background<'_> {
    /// Takes what the tick has reported, advances time to tick `now`, and hands over events. Call it once a period or
    /// more seldom, after the frames that have arrived were given to [`node`](Self::node) and before those that it
    /// sends are taken from there.
    pub fn run(&mut self, now: u64) {
        while let Some(status) = self.statuses.dequeue() {
            self.node.handle_status(status);
        }
        while self.node.takes_scope_report()
            && let Some(report) = self.reports.dequeue()
        {
            self.node.handle_scope(report);
        }
        self.node.poll(now);
        self.hand_over();
    }

    /// The node: its frames, inputs, outputs and actions. Its events are taken by [`run`](Self::run).
    pub const fn node(&mut self) -> &mut Node {
        &mut self.node
    }

    /// Moves what the tick has to get, as far as there is room.
    fn hand_over(&mut self) {
        while self.events.ready()
            && let Some(event) = self.node.poll_event()
        {
            // Room was just seen, and nobody else fills it.
            let _ = self.events.enqueue(event);
        }
        if self.requests.ready()
            && let Some(request) = self.node.poll_scope()
        {
            let _ = self.requests.enqueue(request);
        }
    }
}
