//! The bench's node: the real one, and what its shell does with it written down where that is wanted.

use core::ops::Deref;
use narx_core::bus::{BusState, Frame};
use narx_core::device::DeviceNode;
use narx_core::motor::machine::event::{Event, Health, Status};
#[cfg(feature = "update")]
use narx_core::node::update;
use narx_core::node::{Action, Node, Outputs, SlowInputs};
use narx_core::{scope, storage};
#[cfg(feature = "transcripts")]
use {
    crate::recording::RecordingBuffer,
    alloc::vec::Vec,
    narx_core::node::Identity,
    narx_core::recording::transcript::{NodeCall, NodeSetup, Transcriber},
};

/// A node, to be looked at as one; what alters it goes through here.
#[derive(Clone, Debug)]
pub(crate) struct BenchNode {
    node: Node,
    #[cfg(feature = "transcripts")]
    notes: Option<Notes>,
}

impl Deref for BenchNode {
    type Target = Node;

    fn deref(&self) -> &Node {
        &self.node
    }
}

/// A transcript in the making, and what was written down last of what is told again and again.
#[cfg(feature = "transcripts")]
#[derive(Clone, Debug)]
struct Notes {
    transcriber: Transcriber<Node, RecordingBuffer>,
    now: u64,
    bus: BusState,
    outputs: Option<Outputs>,
}

/// Writes a call down. Nothing of it is compiled into a bench without transcripts.
macro_rules! told {
    ($self:ident, $call:expr) => {
        #[cfg(feature = "transcripts")]
        $self.note(|notes| notes.transcriber.told($call));
    };
}

/// Asks the node, and writes down what it has answered if it has. Without a transcript an answer goes through
/// no other hands: an event is large.
macro_rules! asked {
    ($self:ident, $call:ident, $ask:expr) => {{
        #[cfg(feature = "transcripts")]
        if $self.notes.is_some() {
            let answer = $ask;
            if answer.is_some() {
                $self.note(|notes| notes.transcriber.asked(NodeCall::$call, &answer));
            }
            return answer;
        }
        $ask
    }};
}

impl BenchNode {
    pub(crate) const fn new(node: Node) -> Self {
        Self {
            node,
            #[cfg(feature = "transcripts")]
            notes: None,
        }
    }

    pub(crate) fn attach_storage(&mut self, opened: &storage::Opened) {
        told!(self, NodeCall::AttachStorage(opened.clone()));
        self.node.attach_storage(opened);
    }

    pub(crate) fn handle_frame(&mut self, frame: &Frame) {
        told!(self, NodeCall::Frame(*frame));
        self.node.handle_frame(frame);
    }

    /// Told in every tick, written down where it is another one.
    pub(crate) fn handle_bus_state(&mut self, state: BusState) {
        #[cfg(feature = "transcripts")]
        self.note(|notes| {
            let known = core::mem::replace(&mut notes.bus, state) == state;
            if known { Ok(()) } else { notes.transcriber.told(NodeCall::BusState(state)) }
        });
        self.node.handle_bus_state(state);
    }

    pub(crate) fn handle_inputs(&mut self, inputs: SlowInputs) {
        told!(self, NodeCall::Inputs(inputs));
        self.node.handle_inputs(inputs);
    }

    pub(crate) fn handle_health(&mut self, health: Health) {
        told!(self, NodeCall::Health(health));
        self.node.handle_health(health);
    }

    pub(crate) fn handle_storage(&mut self, report: storage::FlashReply) {
        told!(self, NodeCall::Storage(report.clone()));
        self.node.handle_storage(report);
    }

    pub(crate) fn poll_frame(&mut self) -> Option<Frame> {
        asked!(self, PollFrame, self.node.poll_frame())
    }

    pub(crate) fn poll_bulk_frame(&mut self) -> Option<Frame> {
        asked!(self, PollBulkFrame, self.node.poll_bulk_frame())
    }

    pub(crate) fn poll_storage(&mut self) -> Option<storage::FlashTask> {
        asked!(self, PollStorage, self.node.poll_storage())
    }

    pub(crate) fn poll_action(&mut self) -> Option<Action> {
        asked!(self, PollAction, self.node.poll_action())
    }

    /// Looked at in every tick, written down where they are other ones.
    pub(crate) fn outputs(&mut self) -> Outputs {
        let outputs = self.node.outputs();
        #[cfg(feature = "transcripts")]
        self.note(|notes| {
            let known = notes.outputs.replace(outputs) == Some(outputs);
            if known { Ok(()) } else { notes.transcriber.asked(NodeCall::Outputs, &outputs) }
        });
        outputs
    }

    #[cfg(feature = "update")]
    pub(crate) fn attach_update(&mut self, slots: &update::Slots) {
        told!(self, NodeCall::AttachUpdate(*slots));
        self.node.attach_update(slots);
    }

    #[cfg(feature = "update")]
    pub(crate) fn handle_update(&mut self, report: update::SlotReply) {
        told!(self, NodeCall::Update(report));
        self.node.handle_update(report);
    }

    #[cfg(feature = "update")]
    pub(crate) fn poll_update(&mut self) -> Option<update::SlotTask> {
        asked!(self, PollUpdate, self.node.poll_update())
    }
}

impl DeviceNode for BenchNode {
    fn handle_status(&mut self, status: Status) {
        told!(self, NodeCall::Status(status));
        self.node.handle_status(status);
    }

    fn takes_scope_report(&self) -> bool {
        self.node.takes_scope_report()
    }

    fn handle_scope(&mut self, report: scope::ScopeReply) {
        told!(self, NodeCall::Scope(report));
        self.node.handle_scope(report);
    }

    fn poll(&mut self, now: u64) {
        #[cfg(feature = "transcripts")]
        self.note(|notes| {
            let before = core::mem::replace(&mut notes.now, now);
            notes.transcriber.told(NodeCall::Poll(now.wrapping_sub(before)))
        });
        self.node.poll(now);
    }

    fn poll_event(&mut self) -> Option<Event> {
        asked!(self, PollEvent, self.node.poll_event())
    }

    fn poll_scope(&mut self) -> Option<scope::ScopeTask> {
        asked!(self, PollScope, self.node.poll_scope())
    }
}

#[cfg(feature = "transcripts")]
impl BenchNode {
    /// Begins a transcript. The node has just been powered up.
    pub(super) fn begin_transcript(&mut self, identity: Identity, label: &str) {
        let board = *self.node.board();
        let setup = NodeSetup::new(identity, board, self.node.parameters().clone());
        let sink = RecordingBuffer::default();
        self.notes = Transcriber::new(sink, board.tick_rate, label, &setup).ok().map(|transcriber| Notes {
            transcriber,
            // The first call says when that is.
            now: 0,
            bus: BusState::default(),
            outputs: None,
        });
    }

    /// The transcript so far; nothing without one.
    pub(super) fn transcript(&self) -> Vec<u8> {
        let finished = self.notes.clone().and_then(|notes| notes.transcriber.finish(&self.node).ok());
        finished.unwrap_or_default().0
    }

    /// A call that does not fit ends the transcript: what there is of it would be another story.
    fn note<E>(&mut self, write: impl FnOnce(&mut Notes) -> Result<(), E>) {
        if let Some(notes) = &mut self.notes
            && write(notes).is_err()
        {
            self.notes = None;
        }
    }
}
