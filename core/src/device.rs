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
//! Either half may interrupt the other at any instant: nothing but the queues is shared. A shell with one
//! thread keeps both in a [`Device`], and sees by a [`Tap`] what goes from one to the other.

use crate::dictionary::Parameters;
use crate::motor::{Board, Coefficients, Drive, Event, PwmCommand, Samples, Status};
use crate::node::{Identity, Node};
use crate::queue::{dequeue, enqueue, has_room};
use crate::scope::{Answer, Keeper, Memory, Order, SCOPE, Scope, ScopeReply, ScopeTask};
use core::borrow::BorrowMut;
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

/// The queues between the halves of one device. `H` holds the scope's memory: a reference, or a box.
#[derive(Clone, Debug)]
pub struct Links<H> {
    events: Queue<Event, EVENTS>,
    statuses: Queue<Status, STATUSES>,
    orders: Queue<Order<H>, ORDERS>,
    answers: Queue<Answer<H>, ANSWERS>,
}

/// The queues of a device whose halves are apart. The scope's memory comes from outside.
pub type Queues<'m> = Links<&'m mut Memory>;

impl<H> Default for Links<H> {
    fn default() -> Self {
        Self::new()
    }
}

impl<H> Links<H> {
    /// Empty queues.
    pub const fn new() -> Self {
        Self { events: Queue::new(), statuses: Queue::new(), orders: Queue::new(), answers: Queue::new() }
    }

    /// The ends of both halves.
    #[inline]
    fn split(&mut self) -> (TickEnds<'_, H>, BackgroundEnds<'_, H>) {
        let (events_in, events) = self.events.split();
        let (statuses, statuses_out) = self.statuses.split();
        let (orders_in, orders) = self.orders.split();
        let (answers, answers_out) = self.answers.split();
        (
            TickEnds { events, statuses, orders, answers },
            BackgroundEnds {
                events: events_in,
                statuses: statuses_out,
                orders: orders_in,
                answers: answers_out,
            },
        )
    }
}

impl<'m> Queues<'m> {
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
        let (tick, background) = self.split();
        let mut background =
            Background { half: BackgroundHalf { node, keeper: Keeper::default() }, ends: background };
        background.half.hand_over(&mut background.ends);
        (ControlTick { half: TickHalf { drive, scope: Scope::default() }, ends: tick }, background)
    }
}

/// Builds the coefficients. A stored set that does not build refuses every start; until it is corrected, boot
/// and protection have the factory's values. Out of line, like everything that is done once at power-up:
/// inlined field by field into the caller, it takes twice the flash.
#[inline(never)]
fn built(parameters: &Parameters, board: &Board) -> Coefficients {
    let stored = Coefficients::build(parameters, board);
    stored.or_else(|_| Coefficients::build(&Parameters::new(), board)).unwrap_or_default()
}

/// Sees what goes from one half to the other, as the control tick takes and gives it.
pub trait Tap {
    /// Sees the event of this tick, before the drive takes it.
    fn see_event(&mut self, event: &Event);
    /// Sees the report of this tick.
    fn see_status(&mut self, status: &Status);
}

/// Sees nothing.
impl Tap for () {
    #[inline]
    fn see_event(&mut self, _: &Event) {}
    #[inline]
    fn see_status(&mut self, _: &Status) {}
}

/// The control tick's ends of the queues.
struct TickEnds<'q, H> {
    events: Consumer<'q, Event>,
    statuses: Producer<'q, Status>,
    orders: Consumer<'q, Order<H>>,
    answers: Producer<'q, Answer<H>>,
}

/// Drive and scope.
#[derive(Clone, Debug)]
struct TickHalf<H> {
    drive: Drive,
    scope: Scope<H>,
}

impl<H: BorrowMut<Memory>> TickHalf<H> {
    #[inline]
    fn step(&mut self, ends: &mut TickEnds<'_, H>, samples: &Samples, tap: &mut impl Tap) -> PwmCommand {
        self.take_event(ends, tap);
        let command = self.drive.step(samples);
        if has_room(&ends.statuses)
            && let Some(status) = self.drive.poll_status()
        {
            tap.see_status(&status);
            // There is room: it was checked above, and nothing else fills it.
            let _ = enqueue(&mut ends.statuses, status);
        }
        if SCOPE {
            self.run_scope(ends, samples);
        }
        command
    }

    #[inline]
    fn run_scope(&mut self, ends: &mut TickEnds<'_, H>, samples: &Samples) {
        // The scope's answer from the last tick is sent in this one: a tick in which the scope acts is long
        // enough.
        if self.scope.has_answer()
            && has_room(&ends.answers)
            && let Some(answer) = self.scope.poll()
        {
            // There is room: it was checked above, and nothing else fills it.
            let _ = enqueue(&mut ends.answers, answer);
        }
        if let Some(order) = dequeue(&mut ends.orders) {
            self.scope.handle(order);
        }
        self.scope.step(&self.drive, samples);
    }

    /// Takes the waiting event in place, without a move: it is large.
    #[cfg(not(thread_sanitizer))]
    #[inline]
    fn take_event(&mut self, ends: &mut TickEnds<'_, H>, tap: &mut impl Tap) {
        if !ends.events.ready() {
            return;
        }
        // `ready` reads without memory ordering: another processor may see the event's words later.
        fence(Ordering::Acquire);
        if let Some(event) = ends.events.peek() {
            tap.see_event(event);
            self.scope.handle_event(event);
            self.drive.handle_event(event);
            dequeue(&mut ends.events);
        }
    }

    /// Takes the waiting event under ThreadSanitizer, which does not know fences: moved out, the event is
    /// ordered by the queue.
    #[cfg(thread_sanitizer)]
    fn take_event(&mut self, ends: &mut TickEnds<'_, H>, tap: &mut impl Tap) {
        if let Some(event) = dequeue(&mut ends.events) {
            tap.see_event(&event);
            self.scope.handle_event(&event);
            self.drive.handle_event(&event);
        }
    }
}

/// The half of the control interrupt.
pub struct ControlTick<'q, 'm> {
    half: TickHalf<&'m mut Memory>,
    ends: TickEnds<'q, &'m mut Memory>,
}

impl ControlTick<'_, '_> {
    /// One control tick: takes at most one event, and reports if a report is due.
    #[inline(never)]
    pub fn step(&mut self, samples: &Samples) -> PwmCommand {
        self.half.step(&mut self.ends, samples, &mut ())
    }

    /// The drive, for inspection.
    pub const fn drive(&self) -> &Drive {
        &self.half.drive
    }
}

/// The node as the background of a device sees it: the node itself, or one whose calls are written down.
pub trait DeviceNode {
    /// [`Node::handle_status`].
    fn handle_status(&mut self, status: Status);
    /// [`Node::takes_scope_report`].
    fn takes_scope_report(&self) -> bool;
    /// [`Node::handle_scope`].
    fn handle_scope(&mut self, report: ScopeReply);
    /// [`Node::poll`].
    fn poll(&mut self, now: u64);
    /// [`Node::poll_event`].
    fn poll_event(&mut self) -> Option<Event>;
    /// [`Node::poll_scope`].
    fn poll_scope(&mut self) -> Option<ScopeTask>;
}

impl DeviceNode for Node {
    #[inline]
    fn handle_status(&mut self, status: Status) {
        Self::handle_status(self, status);
    }
    #[inline]
    fn takes_scope_report(&self) -> bool {
        Self::takes_scope_report(self)
    }
    #[inline]
    fn handle_scope(&mut self, report: ScopeReply) {
        Self::handle_scope(self, report);
    }
    #[inline]
    fn poll(&mut self, now: u64) {
        Self::poll(self, now);
    }
    #[inline]
    fn poll_event(&mut self) -> Option<Event> {
        Self::poll_event(self)
    }
    #[inline]
    fn poll_scope(&mut self) -> Option<ScopeTask> {
        Self::poll_scope(self)
    }
}

/// The background's ends of the queues.
struct BackgroundEnds<'q, H> {
    events: Producer<'q, Event>,
    statuses: Consumer<'q, Status>,
    orders: Producer<'q, Order<H>>,
    answers: Consumer<'q, Answer<H>>,
}

/// Node and keeper of the scope's memory.
#[derive(Clone, Debug)]
struct BackgroundHalf<H, N> {
    node: N,
    keeper: Keeper<H>,
}

impl<H: BorrowMut<Memory>, N: DeviceNode> BackgroundHalf<H, N> {
    #[inline]
    fn run(&mut self, ends: &mut BackgroundEnds<'_, H>, now: u64) {
        while let Some(status) = dequeue(&mut ends.statuses) {
            self.node.handle_status(status);
        }
        if SCOPE {
            self.take_answers(ends);
        }
        self.node.poll(now);
        self.hand_over(ends);
        if SCOPE {
            self.hand_over_order(ends);
        }
    }

    /// Passes the scope's reports to the node.
    fn take_answers(&mut self, ends: &mut BackgroundEnds<'_, H>) {
        while let Some(answer) = dequeue(&mut ends.answers) {
            self.keeper.take(answer);
        }
        while self.node.takes_scope_report()
            && let Some(report) = self.keeper.poll_report()
        {
            self.node.handle_scope(report);
        }
    }

    /// Moves the node's events to the tick, as far as there is room.
    fn hand_over(&mut self, ends: &mut BackgroundEnds<'_, H>) {
        while has_room(&ends.events)
            && let Some(event) = self.node.poll_event()
        {
            // There is room: it was checked above, and nothing else fills it.
            let _ = enqueue(&mut ends.events, event);
        }
    }

    /// Passes the node's request to the scope.
    fn hand_over_order(&mut self, ends: &mut BackgroundEnds<'_, H>) {
        if !self.keeper.has_order()
            && let Some(request) = self.node.poll_scope()
        {
            self.keeper.handle(request);
        }
        if has_room(&ends.orders)
            && let Some(order) = self.keeper.poll_order()
        {
            let _ = enqueue(&mut ends.orders, order);
        }
    }
}

/// The half of the background loop.
pub struct Background<'q, 'm> {
    half: BackgroundHalf<&'m mut Memory, Node>,
    ends: BackgroundEnds<'q, &'m mut Memory>,
}

impl<'m> Background<'_, 'm> {
    /// Gives the virtual scope its memory, before the first tick. Without any it cannot be armed.
    pub fn attach_scope(&mut self, memory: &'m mut Memory) {
        self.half.keeper = Keeper::new(memory);
    }

    /// Takes the tick's reports, advances time to tick `now`, and hands over events. Call it once a period or
    /// less often, after the received frames were given to [`node`](Self::node), and before its frames are
    /// taken from there.
    #[inline(never)]
    pub fn run(&mut self, now: u64) {
        self.half.run(&mut self.ends, now);
    }

    /// The node: its frames, inputs, outputs and actions. Its events are taken by [`run`](Self::run).
    pub const fn node(&mut self) -> &mut Node {
        &mut self.half.node
    }
}

/// A device in one piece, for a shell that runs both halves in turn on one thread.
#[derive(Clone, Debug)]
pub struct Device<H, N = Node> {
    tick: TickHalf<H>,
    background: BackgroundHalf<H, N>,
    links: Links<H>,
}

impl<H: BorrowMut<Memory>, N: DeviceNode> Device<H, N> {
    /// Makes a device at power-up with this node, which has the same board and parameters. If the set does
    /// not build, the drive has none: the node reports that, and the drive refuses to start.
    pub fn power_up(node: N, board: &Board, parameters: &Parameters, memory: H) -> Self {
        let mut device = Self {
            tick: TickHalf { drive: Drive::new(built(parameters, board)), scope: Scope::default() },
            background: BackgroundHalf { node, keeper: Keeper::new(memory) },
            links: Links::new(),
        };
        device.background.hand_over(&mut device.links.split().1);
        device
    }

    /// One control tick, as [`ControlTick::step`].
    pub fn step(&mut self, samples: &Samples, tap: &mut impl Tap) -> PwmCommand {
        self.tick.step(&mut self.links.split().0, samples, tap)
    }

    /// One turn of the background, as [`Background::run`].
    pub fn run(&mut self, now: u64) {
        self.background.run(&mut self.links.split().1, now);
    }

    /// The drive, for inspection.
    pub const fn drive(&self) -> &Drive {
        &self.tick.drive
    }

    /// The node, for inspection.
    pub const fn node(&self) -> &N {
        &self.background.node
    }

    /// The node: its frames, inputs, outputs and actions. Its events are taken by [`run`](Self::run).
    pub const fn node_mut(&mut self) -> &mut N {
        &mut self.background.node
    }
}
