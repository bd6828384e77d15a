//! A device: drive and node joined by queues. A shell runs one half in its control interrupt, and the other
//! in its background loop.
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
use crate::queue::{dequeue, enqueue, has_room};
use crate::scope::{Answer, Keeper, Memory, Order, SCOPE, Scope};
#[cfg(not(thread_sanitizer))]
use core::sync::atomic::{Ordering, fence};
use heapless::spsc::{Consumer, Producer, Queue};

/// Places of each queue, one of which stays free. An event is as large as the coefficients, and a tick takes
/// no more than one. A report without room is made later, so waiting reports are no older than in a longer
/// queue.
const EVENTS: usize = 2;
const STATUSES: usize = 2;
const ORDERS: usize = 2;
const ANSWERS: usize = 3;

/// The queues between the halves of one device. The scope's memory comes from outside.
#[derive(Debug, Default)]
pub struct Queues<'m> {
    events: Queue<Event, EVENTS>,
    statuses: Queue<Status, STATUSES>,
    orders: Queue<Order<&'m mut Memory>, ORDERS>,
    answers: Queue<Answer<&'m mut Memory>, ANSWERS>,
}

impl<'m> Queues<'m> {
    /// Empty queues.
    pub const fn new() -> Self {
        Self { events: Queue::new(), statuses: Queue::new(), orders: Queue::new(), answers: Queue::new() }
    }

    /// Makes a device at power-up with a stored parameter set. If the set does not build, the drive has none:
    /// the node reports that, and the drive refuses to start.
    #[inline(never)]
    pub fn power_up(
        &mut self,
        identity: Identity,
        board: Board,
        parameters: Parameters,
    ) -> (ControlTick<'_, 'm>, Background<'_, 'm>) {
        // Entries from before a reboot are dropped.
        *self = Self::new();
        let drive = Drive::new(built(&parameters, &board));
        let node = Node::with_parameters(identity, board, parameters);
        let (events_in, events) = self.events.split();
        let (statuses, statuses_out) = self.statuses.split();
        let (orders_in, orders) = self.orders.split();
        let (answers, answers_out) = self.answers.split();
        let mut background = Background {
            node,
            events: events_in,
            statuses: statuses_out,
            keeper: Keeper::default(),
            orders: orders_in,
            answers: answers_out,
        };
        background.hand_over();
        let scope = Scope::default();
        (ControlTick { drive, events, statuses, scope, orders, answers }, background)
    }
}

/// Builds the coefficients. Out of line, like everything that is done once at power-up: inlined field by
/// field into the caller, it takes twice the flash.
#[inline(never)]
fn built(parameters: &Parameters, board: &Board) -> Coefficients {
    Coefficients::build(parameters, board).unwrap_or_default()
}

/// The half of the control interrupt.
pub struct ControlTick<'q, 'm> {
    drive: Drive,
    events: Consumer<'q, Event>,
    statuses: Producer<'q, Status>,
    scope: Scope<&'m mut Memory>,
    orders: Consumer<'q, Order<&'m mut Memory>>,
    answers: Producer<'q, Answer<&'m mut Memory>>,
}

impl ControlTick<'_, '_> {
    /// One control tick: takes at most one event, and reports if a report is due.
    #[inline(never)]
    pub fn step(&mut self, samples: &Samples) -> PwmCommand {
        self.heed_event();
        let command = self.drive.step(samples);
        if has_room(&self.statuses)
            && let Some(status) = self.drive.poll_status()
        {
            // There is room: it was checked above, and nothing else fills it.
            let _ = enqueue(&mut self.statuses, status);
        }
        if SCOPE {
            self.run_scope(samples);
        }
        command
    }

    #[inline]
    fn run_scope(&mut self, samples: &Samples) {
        // The scope's answer from the last tick is sent in this one: a tick in which the scope acts is long
        // enough.
        if self.scope.has_answer()
            && has_room(&self.answers)
            && let Some(answer) = self.scope.poll()
        {
            // There is room: it was checked above, and nothing else fills it.
            let _ = enqueue(&mut self.answers, answer);
        }
        if let Some(order) = dequeue(&mut self.orders) {
            self.scope.handle(order);
        }
        self.scope.step(&self.drive, samples);
    }

    /// Takes the waiting event in place, without a move: it is large.
    #[cfg(not(thread_sanitizer))]
    #[inline]
    fn heed_event(&mut self) {
        if !self.events.ready() {
            return;
        }
        // `ready` reads without memory ordering: another processor may see the event's words later.
        fence(Ordering::Acquire);
        if let Some(event) = self.events.peek() {
            self.scope.handle_event(event);
            self.drive.handle_event(event);
            dequeue(&mut self.events);
        }
    }

    /// Takes the waiting event under ThreadSanitizer, which does not know fences: moved out, the event is
    /// ordered by the queue.
    #[cfg(thread_sanitizer)]
    fn heed_event(&mut self) {
        if let Some(event) = dequeue(&mut self.events) {
            self.scope.handle_event(&event);
            self.drive.handle_event(&event);
        }
    }

    /// The drive, for inspection.
    pub const fn drive(&self) -> &Drive {
        &self.drive
    }
}

/// The half of the background loop.
pub struct Background<'q, 'm> {
    node: Node,
    events: Producer<'q, Event>,
    statuses: Consumer<'q, Status>,
    keeper: Keeper<&'m mut Memory>,
    orders: Producer<'q, Order<&'m mut Memory>>,
    answers: Consumer<'q, Answer<&'m mut Memory>>,
}

impl<'m> Background<'_, 'm> {
    /// Gives the virtual scope its memory, before the first tick. Without any it cannot be armed.
    pub fn attach_scope(&mut self, memory: &'m mut Memory) {
        self.keeper = Keeper::new(memory);
    }

    /// Takes the tick's reports, advances time to tick `now`, and hands over events. Call it once a period or
    /// less often, after the received frames were given to [`node`](Self::node), and before its frames are
    /// taken from there.
    #[inline(never)]
    pub fn run(&mut self, now: u64) {
        while let Some(status) = dequeue(&mut self.statuses) {
            self.node.handle_status(status);
        }
        if SCOPE {
            self.take_answers();
        }
        self.node.poll(now);
        self.hand_over();
        if SCOPE {
            self.hand_over_order();
        }
    }

    /// Passes the scope's reports to the node.
    fn take_answers(&mut self) {
        while let Some(answer) = dequeue(&mut self.answers) {
            self.keeper.take(answer);
        }
        while self.node.takes_scope_report()
            && let Some(report) = self.keeper.poll_report()
        {
            self.node.handle_scope(report);
        }
    }

    /// The node: its frames, inputs, outputs and actions. Its events are taken by [`run`](Self::run).
    pub const fn node(&mut self) -> &mut Node {
        &mut self.node
    }

    /// Moves the node's events to the tick, as far as there is room.
    fn hand_over(&mut self) {
        while has_room(&self.events)
            && let Some(event) = self.node.poll_event()
        {
            // There is room: it was checked above, and nothing else fills it.
            let _ = enqueue(&mut self.events, event);
        }
    }

    /// Passes the node's request to the scope.
    fn hand_over_order(&mut self) {
        if !self.keeper.has_order()
            && let Some(request) = self.node.poll_scope()
        {
            self.keeper.handle(request);
        }
        if has_room(&self.orders)
            && let Some(order) = self.keeper.poll_order()
        {
            let _ = enqueue(&mut self.orders, order);
        }
    }
}
