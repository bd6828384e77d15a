//! Condition of the device: cause of its start, failed self-tests, diagnostics.

use super::Node;
use crate::dictionary::number;
use crate::motor::machine::event::Health;
use bitflags::bitflags;
use serde::{Deserialize, Serialize};

/// Cause of the device's start (parameter 302).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// The board cannot tell.
    #[default]
    Unknown = 0,
    /// The supply came.
    PowerUp = 1,
    /// The reset line.
    Pin = 2,
    /// The master's REBOOT, or an update.
    Requested = 3,
    /// Control, CAN or background stood still.
    Watchdog = 4,
    /// A fault of the processor, or a panic.
    Program = 5,
    /// The supply dipped.
    Supply = 6,
}

bitflags! {
    /// Self-tests (parameter 303).
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    pub struct SelfTests: u16 {
        /// RAM, at boot.
        const RAM = 1 << 0;
        /// The program in its flash, at boot and all the time.
        const FLASH = 1 << 1;
        /// Two clocks of the board against each other, at boot.
        const CLOCK = 1 << 2;
        /// The end of the stack is untouched, all the time.
        const STACK = 1 << 3;
        /// Control ticks against another clock, all the time.
        const TICK = 1 << 4;
    }
}

bitflags! {
    /// Noteworthy conditions that are no faults (parameter 304).
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Diagnostics: u16 {
        /// The bus is below 18 V (Table 2).
        const SUPPLY_LOW = 1 << 0;
        /// The rotor may have turned unseen since power-up, or since parameter 17 set the mechanical
        /// position.
        const POSITION_UNKNOWN = 1 << 1;
        /// Sensorless control is enabled, and a stable wrong lock would not be found: parameter 267 or 268
        /// is 0.
        const WRONG_LOCK_UNSEEN = 1 << 2;
    }
}

impl Node {
    /// Returns the noteworthy conditions that are no faults.
    pub(super) fn diagnostics(&self) -> Diagnostics {
        let is_zero = |number| self.parameters.raw(number) == 0;
        let blind = is_zero(number::BACK_EMF_CONSTANT) || is_zero(number::WINDING_RESISTANCE);
        let mut found = Diagnostics::empty();
        found.set(Diagnostics::SUPPLY_LOW, self.status.supply_low);
        found.set(Diagnostics::POSITION_UNKNOWN, self.position_lost);
        found.set(Diagnostics::WRONG_LOCK_UNSEEN, blind && !is_zero(number::SENSORLESS_ENABLE));
        found
    }

    /// Takes the cause of the start, at power-up.
    pub fn handle_reset_cause(&mut self, cause: ResetCause) {
        self.put(number::RESET_CAUSE, cause as i32);
    }

    /// Takes the self-tests that have failed since power-up; call it when one more has failed. Any of them is
    /// fault bit 27, and the drive does not start.
    pub fn handle_self_tests(&mut self, failed: SelfTests) {
        self.put(number::FAILED_SELF_TESTS, failed.bits().into());
        let health = Health { self_test_failed: !failed.is_empty(), ..self.flash.health() };
        self.handle_health(health);
    }
}
