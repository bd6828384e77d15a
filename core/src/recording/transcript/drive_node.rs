//! Transcripts of the drive's node: its set-up and the shell's calls.

use super::{Answers, Transcribable};
use crate::bus::{BusState, Frame};
use crate::dictionary::{Dictionary, Parameters};
use crate::motor::machine::event::{Health, Status};
use crate::motor::sense::front_end::Board;
#[cfg(feature = "update")]
use crate::node::update;
use crate::node::{Identity, Node, ResetCause, SelfTests, SlowInputs};
use crate::recording::{Kind, ReplayError};
use crate::{scope, storage};
use serde::{Deserialize, Serialize};

/// Set-up of a node at power-up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NodeSetup {
    /// Features of the build that change its answers: 1 accelerometer, 2 description, 4 log, 8 scope, 16
    /// recorder. Programming (`update`) is not among them: a node without slots takes no part in it, but its
    /// description lists the messages of its build.
    pub features: u8,
    /// Firmware and board.
    pub identity: Identity,
    /// Its board.
    pub board: Board,
    /// The parameters that were stored.
    pub parameters: Parameters,
}

/// Features of this build.
const FEATURES: u8 = cfg!(feature = "accelerometer") as u8
    | (cfg!(feature = "description") as u8) << 1
    | (cfg!(feature = "log") as u8) << 2
    | (cfg!(feature = "scope") as u8) << 3
    | (cfg!(feature = "recorder") as u8) << 4;

impl NodeSetup {
    /// Set-up of a node of this build.
    pub const fn new(identity: Identity, board: Board, parameters: Parameters) -> Self {
        Self { features: FEATURES, identity, board, parameters }
    }
}

/// Call of a shell to a node: see [`Node`]. A call that asks for an answer is recorded only if there was one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "a set is told rarely, and there is no heap")]
#[allow(missing_docs, reason = "each is the call of the same name")]
pub enum NodeCall {
    Frame(Frame),
    BusState(BusState),
    Status(Status),
    Inputs(SlowInputs),
    Health(Health),
    ResetCause(ResetCause),
    SelfTests(SelfTests),
    AttachStorage(storage::Opened),
    Storage(storage::FlashReply),
    Scope(scope::ScopeReply),
    /// `poll`, this many ticks after the last one.
    Poll(u64),
    PollFrame,
    PollBulkFrame,
    PollEvent,
    PollStorage,
    PollScope,
    PollAction,
    /// Levels that differ from those before.
    Outputs,
    #[cfg(feature = "update")]
    AttachUpdate(update::Slots),
    #[cfg(feature = "update")]
    Update(update::SlotReply),
    #[cfg(feature = "update")]
    PollUpdate,
}

impl Transcribable for Node {
    const KIND: Kind = Kind::Node;
    type Setup = NodeSetup;
    type Call = NodeCall;

    fn power_up(setup: NodeSetup) -> Result<Self, ReplayError> {
        if setup.features != FEATURES {
            return Err(ReplayError::Features { recorded: setup.features, here: FEATURES });
        }
        Ok(Self::with_parameters(setup.identity, setup.board, setup.parameters))
    }

    fn call(&mut self, call: &NodeCall, clock: &mut u64, answers: &mut Answers) {
        match call {
            NodeCall::Frame(frame) => self.handle_frame(frame),
            NodeCall::BusState(state) => self.handle_bus_state(*state),
            NodeCall::Status(status) => self.handle_status(*status),
            NodeCall::Inputs(inputs) => self.handle_inputs(*inputs),
            NodeCall::Health(health) => self.handle_health(*health),
            NodeCall::ResetCause(cause) => self.handle_reset_cause(*cause),
            NodeCall::SelfTests(failed) => self.handle_self_tests(*failed),
            NodeCall::AttachStorage(opened) => self.attach_storage(opened),
            NodeCall::Storage(report) => self.handle_storage(report.clone()),
            NodeCall::Scope(report) => self.handle_scope(*report),
            NodeCall::Poll(ticks) => {
                *clock = clock.wrapping_add(*ticks);
                self.poll(*clock);
            }
            NodeCall::PollFrame => answers.answer(call, &self.poll_frame()),
            NodeCall::PollBulkFrame => answers.answer(call, &self.poll_bulk_frame()),
            NodeCall::PollEvent => answers.answer(call, &self.poll_event()),
            NodeCall::PollStorage => answers.answer(call, &self.poll_storage()),
            NodeCall::PollScope => answers.answer(call, &self.poll_scope()),
            NodeCall::PollAction => answers.answer(call, &self.poll_action()),
            NodeCall::Outputs => answers.answer(call, &self.outputs()),
            #[cfg(feature = "update")]
            NodeCall::AttachUpdate(slots) => self.attach_update(slots),
            #[cfg(feature = "update")]
            NodeCall::Update(report) => self.handle_update(*report),
            #[cfg(feature = "update")]
            NodeCall::PollUpdate => answers.answer(call, &self.poll_update()),
        }
    }

    /// Notes every parameter as a master would read it, and the lines.
    fn show(&self, answers: &mut Answers) {
        for row in Dictionary::rows() {
            answers.note(&self.read_parameter(row.number));
        }
        answers.note(&self.outputs());
    }
}
