//! The master's commands for the motor, on their way to the control tick.

use super::scale;
use crate::bus::narmotion::MotorMode;
use crate::dictionary::{Parameters, number};
use crate::motor::machine::event::{Command, Event, RunRequest};
use crate::units::ElectricalSpeed;
use heapless::Deque;
use serde::{Deserialize, Serialize};

/// Commands that may wait for the tick, which takes one each 100 us.
const WAITING: usize = 8;

/// The last set-point, and the commands that wait.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct Commands {
    /// Magnitude of the mechanical set-point, rpm.
    speed: u16,
    mode: Mode,
    waiting: Deque<Waiting, WAITING>,
}

/// A command on its way; without a request it is a set-point alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Waiting {
    request: Option<RunRequest>,
    speed: ElectricalSpeed,
}

/// Control mode that the enables select (Table 6); frozen while the drive is not stopped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Mode {
    #[default]
    None,
    OpenLoop,
    Sensorless,
    Hall,
}

impl Commands {
    /// Takes a valid REQUEST_WORD.
    pub(super) fn request(&mut self, mode: MotorMode, parameters: &Parameters) {
        let request = match mode {
            MotorMode::Standby => RunRequest::Standby,
            MotorMode::Drive => RunRequest::Drive,
            MotorMode::Reverse => RunRequest::Reverse,
            MotorMode::Fault => RunRequest::Shutdown,
        };
        self.push(Some(request), parameters);
    }

    /// Takes a valid MOTOR_CMD. Returns the accepted set-point, limited by the saturation of the control
    /// mode; open loop has its own set-point (parameter 88).
    pub(super) fn set_speed(&mut self, speed: u16, parameters: &Parameters) -> u16 {
        self.speed = speed;
        self.push(None, parameters);
        let (min, max) = match self.mode {
            Mode::None => (0, u16::MAX.into()),
            Mode::OpenLoop => {
                let fixed = parameters.raw(number::OPEN_LOOP_SPEED);
                (fixed, fixed)
            }
            Mode::Sensorless => {
                (parameters.speed_limit(number::SPEED_MIN_SL), parameters.speed_limit(number::SPEED_MAX_SL))
            }
            Mode::Hall => {
                (parameters.speed_limit(number::SPEED_MIN_HES), parameters.speed_limit(number::SPEED_MAX_HES))
            }
        };
        // Not `clamp`, which panics when min > max: such a set does not build, but can be written.
        i32::from(speed).max(min).min(max).clamp(0, u16::MAX.into()) as u16
    }

    /// Takes over the control mode of the enables, while the drive is stopped.
    pub(super) fn select_mode(&mut self, parameters: &Parameters) {
        let enabled = |number| parameters.raw(number) != 0;
        self.mode = if enabled(number::HALL_ENABLE) {
            Mode::Hall
        } else if enabled(number::SENSORLESS_ENABLE) {
            Mode::Sensorless
        } else if enabled(number::OPEN_LOOP_ENABLE) {
            Mode::OpenLoop
        } else {
            Mode::None
        };
    }

    /// The next command for the tick.
    pub(super) fn pop(&mut self) -> Option<Event> {
        let Waiting { request, speed } = self.waiting.pop_front()?;
        Some(match request {
            Some(request) => Event::Command(Command { request, speed }),
            None => Event::SetPoint(speed),
        })
    }

    /// Queues a request, or a set-point alone. It is merged into the last entry if one of them has no
    /// request, or both have the same: every change of request reaches the tick, and so does the newest
    /// set-point.
    fn push(&mut self, request: Option<RunRequest>, parameters: &Parameters) {
        let speed = scale::electrical_speed(self.speed.into(), parameters.raw(number::MOTOR_POLE_PAIRS));
        if let Some(last) = self.waiting.back_mut()
            && (request.is_none() || last.request.is_none() || last.request == request)
        {
            *last = Waiting { request: request.or(last.request), speed };
            return;
        }
        if self.waiting.is_full() {
            self.condense();
        }
        // There is room now.
        let _ = self.waiting.push_back(Waiting { request, speed });
    }

    /// Replaces a full queue by one request that stops the motor: Shutdown if one waits, else Standby. Starts
    /// are dropped.
    fn condense(&mut self) {
        let shutdown = self.waiting.iter().any(|waiting| waiting.request == Some(RunRequest::Shutdown));
        let request = if shutdown { RunRequest::Shutdown } else { RunRequest::Standby };
        self.waiting.clear();
        let _ = self.waiting.push_back(Waiting { request: Some(request), speed: ElectricalSpeed::ZERO });
    }
}

impl PartialEq for Commands {
    fn eq(&self, other: &Self) -> bool {
        (self.speed, self.mode) == (other.speed, other.mode) && self.waiting.iter().eq(other.waiting.iter())
    }
}
