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
use crate::queue::{dequeue, enqueue, has_room};
use crate::scope::{Answer, Keeper, Memory, Order, SCOPE, Scope};
#[cfg(not(thread_sanitizer))]
use core::sync::atomic::{Ordering, fence};
use heapless::spsc::{Consumer, Producer, Queue};

/// Room of a queue, one of which stays free. An event takes as much as the coefficients, and the tick takes no more than one. A report that
/// finds no room is not made yet: what waits is then no older than what a longer queue would hold.
const EVENTS: usize = 2;
const STATUSES: usize = 2;
const ORDERS: usize = 2;
const ANSWERS: usize = 3;

/// The queues between the halves of one device, whose scope has its memory from elsewhere.
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

    /// A device at power-up with a stored parameter set. One that does not build leaves the drive with none: the node
    /// says so, and it refuses to start.
    #[inline(never)]
    pub fn power_up(
        &mut self,
        identity: Identity,
        board: Board,
        parameters: Parameters,
    ) -> (ControlTick<'_, 'm>, Background<'_, 'm>) {
        // What waits from before a reboot belongs to nobody.
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

/// Out of line, like what else is done once at power-up: laid out field by field among the caller's, it takes twice the flash.
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
            // Room was just seen, and nobody else fills it.
            let _ = enqueue(&mut self.statuses, status);
        }
        if SCOPE {
            self.run_scope(samples);
        }
        command
    }

    #[inline]
    fn run_scope(&mut self, samples: &Samples) {
        // What the scope did in the tick before is told in this one: a tick in which something happens is long enough.
        if self.scope.has_answer()
            && has_room(&self.answers)
            && let Some(answer) = self.scope.poll()
        {
            // Room was just seen, and nobody else fills it.
            let _ = enqueue(&mut self.answers, answer);
        }
        if let Some(order) = dequeue(&mut self.orders) {
            self.scope.handle(order);
        }
        self.scope.step(&self.drive, samples);
    }

    /// Takes the event that waits, where it lies: it is large.
    #[cfg(not(thread_sanitizer))]
    #[inline]
    fn heed_event(&mut self) {
        if !self.events.ready() {
            return;
        }
        // That there is one was read without any ordering: on another processor its words may be seen later.
        fence(Ordering::Acquire);
        if let Some(event) = self.events.peek() {
            self.scope.handle_event(event);
            self.drive.handle_event(event);
            dequeue(&mut self.events);
        }
    }

    /// The same for ThreadSanitizer, which does not know fences: moved out, it is ordered by the queue.
    #[cfg(thread_sanitizer)]
    fn heed_event(&mut self) {
        if let Some(event) = dequeue(&mut self.events) {
            self.scope.handle_event(&event);
            self.drive.handle_event(&event);
        }
    }

    /// The drive, to look at.
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

    /// Takes what the tick has reported, advances time to tick `now`, and hands over events. Call it once a period or
    /// more seldom, after the frames that have arrived were given to [`node`](Self::node) and before those that it
    /// sends are taken from there.
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

    /// From the scope to the node.
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

    /// Moves what the tick has to get, as far as there is room.
    fn hand_over(&mut self) {
        while has_room(&self.events)
            && let Some(event) = self.node.poll_event()
        {
            // Room was just seen, and nobody else fills it.
            let _ = enqueue(&mut self.events, event);
        }
    }

    /// From the node to the scope.
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
