//! State of a CAN controller.

use crate::status::narx_status_t::{self, *};
use narx_core::bus::{BusState, ErrorState};

/// Fault confinement of the CAN controller (ISO 11898-1).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_bus_state_t {
    /// 0: error active, 1: error passive, 2: off the bus.
    pub error: u8,
    /// Transmit error counter.
    pub transmit_errors: u16,
    /// Receive error counter.
    pub receive_errors: u16,
}

impl TryFrom<&narx_bus_state_t> for BusState {
    type Error = narx_status_t;

    fn try_from(state: &narx_bus_state_t) -> Result<Self, narx_status_t> {
        let &narx_bus_state_t { error, transmit_errors, receive_errors } = state;
        let states = [ErrorState::Active, ErrorState::Passive, ErrorState::BusOff];
        let error = states.get(usize::from(error)).copied().ok_or(NARX_ERROR_BUS_STATE)?;
        Ok(Self { error, transmit_errors, receive_errors })
    }
}
