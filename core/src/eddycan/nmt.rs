//! States and commands (section 3.4).

use super::{Restart, TxDriver};
use crate::bus::eddycan::{ErrorCode, NmtCommand, NmtState, Target};

impl TxDriver {
    pub(super) fn handle_nmt(&mut self, command: NmtCommand, target: Target) {
        if !target.includes(self.node) {
            return;
        }
        match command {
            NmtCommand::Start => self.enter(NmtState::Operational),
            NmtCommand::Stop => self.enter(NmtState::Stopped),
            NmtCommand::PreOperational => self.enter(NmtState::PreOperational),
            NmtCommand::Reset => self.restart = Restart::within_a_second(self.now),
        }
    }

    /// Reports an unknown command only if it names this node; otherwise one wrong broadcast would fill the
    /// bus with errors.
    pub(super) fn handle_unknown_nmt(&mut self, target: Target) {
        if target == Target::Node(self.node) {
            self.outbox.errors.note(ErrorCode::Protocol, self.now);
        }
    }

    /// Enters a state and drops messages that it does not send. A command to enter the present state changes
    /// nothing.
    fn enter(&mut self, state: NmtState) {
        if state == self.state {
            return;
        }
        self.state = state;
        self.timer = Default::default();
        self.outbox.discard_pdos();
        if state == NmtState::Stopped {
            self.outbox.discard_answers();
        }
    }
}
