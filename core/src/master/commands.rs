//! Commands for the motor, repeated every period: a drive whose master falls silent stops (parameter 114).

use crate::bus::narmotion::{MotorMode, RequestWord, ToDrive};

/// The last request and set-point, and when they are due again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Commands {
    /// `None` before the first request: until then set-points are sent alone.
    mode: Option<MotorMode>,
    /// A mode or a speed was asked for.
    asked: bool,
    /// Magnitude, rpm.
    speed: u16,
    /// Time at which the next set-point is due, microseconds.
    due: u64,
    /// The request that follows its set-point.
    pending: Option<MotorMode>,
}

impl Commands {
    /// Asks for a mode, from the next poll on.
    pub(super) const fn request(&mut self, mode: MotorMode) {
        self.mode = Some(mode);
        self.asked = true;
        self.due = 0;
    }

    /// Asks for a speed, from the next poll on.
    pub(super) const fn set_speed(&mut self, speed: u16) {
        self.speed = speed;
        self.asked = true;
        self.due = 0;
    }

    pub(super) const fn mode(&self) -> Option<MotorMode> {
        self.mode
    }

    pub(super) const fn speed(&self) -> u16 {
        self.speed
    }

    /// Time at which the next frame is due. A drive that `drives` gets none before something was asked for:
    /// set-points restart its time-out, and would keep a motor turning that nobody commands any more.
    pub(super) const fn due(&self, drives: bool) -> u64 {
        match self.pending {
            Some(_) => 0,
            None if drives && !self.asked => u64::MAX,
            None => self.due,
        }
    }

    /// Returns the message that is due at `now`: first the set-point, then the request.
    pub(super) fn poll(&mut self, now: u64, period: u64, drives: bool) -> Option<ToDrive> {
        if let Some(mode) = self.pending.take() {
            return Some(ToDrive::RequestWord(RequestWord { mode }));
        }
        if now < self.due(drives) {
            return None;
        }
        self.due = now.saturating_add(period);
        self.pending = self.mode;
        Some(ToDrive::MotorCommand { speed: self.speed })
    }
}
