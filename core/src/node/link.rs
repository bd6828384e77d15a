//! State of the CAN controller, and the node's reaction to bus-off.

use super::Node;
use crate::bus::BusState;
use crate::bus::narmotion::FromDrive;
use serde::{Deserialize, Serialize};

/// The node's view of its controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Link {
    pub(super) state: BusState,
    /// Number of bus-offs since power-up, saturating.
    pub(super) bus_offs: u32,
}

impl Node {
    /// Takes the state of the CAN controller, whenever the shell reads it. Off the bus the node hands out no
    /// frame and drops those that wait; the shell drops those that wait in the controller. Back on the bus
    /// the node begins with a broadcast of the present state. Meanwhile control goes on until the command
    /// time-out expires.
    #[inline(never)]
    pub fn handle_bus_state(&mut self, state: BusState) {
        let was_off = self.link.state.is_off();
        self.link.state = state;
        if state.is_off() == was_off {
            return;
        }
        self.outbox.clear();
        if !was_off {
            self.link.bus_offs = self.link.bus_offs.saturating_add(1);
            return;
        }
        self.autosend.restart();
        let status = self.status;
        if !status.critical.is_empty() {
            self.send(FromDrive::CriticalFault { faults: status.critical, code: status.extended_code });
        }
    }
}
