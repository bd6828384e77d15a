//! Fault confinement of a CAN controller (ISO 11898-1), as the controller tells it.

use serde::{Deserialize, Serialize};

/// Fault confinement state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ErrorState {
    /// Takes part and signals errors with dominant flags.
    #[default]
    Active,
    /// An error counter has passed 127: takes part, but its error flags no longer disturb others.
    Passive,
    /// The transmit error counter has passed 255: takes no part until it has seen 128 times 11 recessive
    /// bits.
    BusOff,
}

/// State of a CAN controller: fault confinement and error counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct BusState {
    /// Fault confinement state.
    pub error: ErrorState,
    /// Transmit error counter.
    pub transmit_errors: u16,
    /// Receive error counter.
    pub receive_errors: u16,
}

impl BusState {
    /// Returns whether the controller is off the bus.
    pub const fn is_off(&self) -> bool {
        matches!(self.error, ErrorState::BusOff)
    }
}
