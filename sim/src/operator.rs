//! A master that keeps a drive running: request word and set-point every period, as the manual's monitor does
//! (set-point auto-send period, 8.4.1).

use narx_core::bus::Frame;
use narx_core::bus::narmotion::{Addresses, MotorMode, RequestWord, ToDrive};

/// An operator at the master's place.
#[derive(Clone, Copy, Debug)]
pub struct Operator {
    /// Whom it talks to, and as whom.
    pub addresses: Addresses,
    /// Between two pairs of frames, ns; 50 ms in the manual.
    pub period_ns: u64,
    /// What is asked for.
    pub mode: MotorMode,
    /// Magnitude of the set-point, mechanical rpm.
    pub speed: u16,
    due: u64,
    pending: Option<ToDrive>,
}

impl Operator {
    /// An operator that asks for Standby.
    pub fn new(addresses: Addresses) -> Self {
        Self { addresses, period_ns: 50_000_000, mode: MotorMode::Standby, speed: 0, due: 0, pending: None }
    }

    /// Asks for a speed, rpm, negative in reverse, from the next call on.
    pub fn start(&mut self, rpm: i32) {
        self.mode = if rpm < 0 { MotorMode::Reverse } else { MotorMode::Drive };
        self.speed = rpm.unsigned_abs().min(u32::from(u16::MAX)) as u16;
        self.due = 0;
    }

    /// Asks for another speed in the direction that was asked for, rpm, from the next call on.
    pub fn set_speed(&mut self, rpm: u16) {
        self.speed = rpm;
        self.due = 0;
    }

    /// Asks for Standby from the next call on.
    pub fn stop(&mut self) {
        self.mode = MotorMode::Standby;
        self.due = 0;
    }

    /// Asks for a shutdown (motor mode 3) from the next call on.
    pub fn shut_down(&mut self) {
        self.mode = MotorMode::Fault;
        self.due = 0;
    }

    /// The next frame that is due at `now`, ns: the set-point, then the request.
    pub fn poll(&mut self, now: u64) -> Option<Frame> {
        if let Some(second) = self.pending.take() {
            return Some(second.encode(self.addresses));
        }
        if now < self.due {
            return None;
        }
        self.due = now + self.period_ns;
        self.pending = Some(ToDrive::RequestWord(RequestWord { mode: self.mode }));
        Some(ToDrive::MotorCommand { speed: self.speed }.encode(self.addresses))
    }
}
