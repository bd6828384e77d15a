//! The state machine: requests and conditions to one of the eight states (section 7, Table 7).

use super::error::{SettingError, within};
use super::{factory, tick_rate, ticks};
use crate::dictionary::number;
use crate::motor::clock::Instant;
use crate::motor::commutate::commutation::Direction;
use crate::motor::machine::state::State;
use crate::motor::machine::{Change, Command, Inputs, Machine, MachineCoefficients, Refusal};
use crate::units::ElectricalSpeed;

/// Settings of a [`StateMachine`]. Durations are 0 to 3 600 000 ms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateSettings {
    /// Ticks a second, 1 000 to 100 000 Hz.
    pub tick_rate: u32,
    /// Boot time (T01).
    pub boot_ms: u32,
    /// Rotor lock (T23).
    pub lock_ms: u32,
    /// Open loop before sensorless (T34).
    pub open_loop_ms: u32,
    /// Auto-restart (T71, T74).
    pub auto_restart_ms: u32,
    /// Wait before a fault can be acknowledged (T61).
    pub fault_wait_ms: u32,
    /// Longest time without a command while driving; more is a fault.
    pub command_timeout_ms: u32,
    /// Open loop may run the motor (Table 6).
    pub open_loop: bool,
    /// The sensorless loop may run the motor (Table 6).
    pub sensorless: bool,
    /// The hall loop may run the motor (Table 6), before the others.
    pub hall: bool,
}

impl Default for StateSettings {
    /// The drive's factory values at 10 kHz, with hall sensors.
    fn default() -> Self {
        Self {
            tick_rate: 10_000,
            open_loop: false,
            sensorless: false,
            hall: true,
            boot_ms: 500,
            lock_ms: const { factory(number::LOCK_DURATION) },
            open_loop_ms: const { factory(number::OPEN_LOOP_DURATION) },
            auto_restart_ms: 2_000,
            fault_wait_ms: const { factory(number::FAULT_WAIT) },
            command_timeout_ms: const { factory(number::CAN_TIMEOUT) },
        }
    }
}

/// The eight states with the memory around the transition table: time in the state, the fresh request, the
/// modes and direction of a start, acknowledgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateMachine {
    ready: MachineCoefficients,
    now: Instant,
    station: Machine,
}

impl StateMachine {
    /// A machine in Initialization.
    ///
    /// # Errors
    /// The setting that is out of range.
    pub fn build(s: &StateSettings) -> Result<Self, SettingError> {
        let rate = tick_rate(s.tick_rate)?;
        let duration = |setting, ms: u32| {
            within(setting, ms.into(), 0, 3_600_000, "ms")?;
            Ok(ticks(ms, rate))
        };
        let coefficients = MachineCoefficients {
            open_loop_enable: s.open_loop,
            sensorless_enable: s.sensorless,
            hall_enable: s.hall,
            boot: duration("boot_ms", s.boot_ms)?,
            lock: duration("lock_ms", s.lock_ms)?,
            open_loop: duration("open_loop_ms", s.open_loop_ms)?,
            auto_restart: duration("auto_restart_ms", s.auto_restart_ms)?,
            fault_wait: duration("fault_wait_ms", s.fault_wait_ms)?,
            command_timeout: duration("command_timeout_ms", s.command_timeout_ms)?,
            ..MachineCoefficients::default()
        };
        Ok(Self::new(coefficients))
    }

    /// A machine in Initialization, with ready-made coefficients, which are not checked.
    pub fn new(ready: MachineCoefficients) -> Self {
        Self { ready, now: Instant::default(), station: Machine::default() }
    }

    /// Its coefficients, for [`new`](Self::new) elsewhere.
    pub const fn ready(&self) -> &MachineCoefficients {
        &self.ready
    }

    /// Takes a command; it restarts the time-out. Standby acknowledges a fault, Drive and Reverse start the
    /// motor if Standby was requested before.
    pub fn handle_command(&mut self, command: Command) {
        self.station.handle_command(self.now, command);
    }

    /// Takes a set-point without a request; it restarts the time-out, too.
    pub fn handle_set_point(&mut self, speed: ElectricalSpeed) {
        self.station.handle_set_point(self.now, speed);
    }

    /// Runs one tick: time passes, at most one transition fires.
    pub fn step(&mut self, inputs: &Inputs) -> Option<Change> {
        self.now = self.now.next();
        self.station.step(&self.ready, self.now, inputs)
    }

    /// Present state.
    pub const fn state(&self) -> State {
        self.station.state()
    }

    /// Ticks in the present state, saturating.
    pub const fn age(&self) -> u32 {
        self.station.age(self.now)
    }

    /// Direction of this start.
    pub const fn direction(&self) -> Direction {
        self.station.direction()
    }

    /// Reason why the last start was refused; stays until Standby is requested.
    pub const fn refusal(&self) -> Refusal {
        self.station.refusal()
    }

    /// Returns whether Drive is requested by a fresh edge in Standby: unless the start is refused, this tick
    /// turns the bridge on.
    pub fn starting(&self) -> bool {
        self.station.starting()
    }
}
