//! What reaches the control tick besides its samples, and what it reports back.

use super::coefficients::Coefficients;
use super::commutation::Direction;
use super::fault::FaultWord;
use super::state::State;
use crate::units::{Amps, Celsius, Duty, ElectricalAngle, ElectricalSpeed, Volts, Watts};
use serde::{Deserialize, Serialize};

/// The node's messages to the tick: at most one is taken at the start of each tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "coefficients change owner by moving, rarely; there is no heap")]
pub enum Event {
    /// A valid REQUEST_WORD arrived: feeds the communication time-out; Standby acknowledges a fault.
    Command(Command),
    /// A valid MOTOR_CMD arrived: a new set-point magnitude, the request stays. Feeds the time-out, acknowledges nothing.
    SetPoint(ElectricalSpeed),
    /// A parameter set that built.
    Coefficients(Coefficients),
    /// The present parameter set does not build: keep the last good coefficients, refuse to start.
    CoefficientsRejected,
    /// Slow measurements, about every 10 ms.
    Slow(SlowMeasurements),
    /// Condition of the parameter store and the boot self-tests.
    Health(Health),
    /// Run the hall calibration at the next start instead of the control mode (true), or not (false).
    CalibrateHall(bool),
}

/// What the master asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Command {
    /// Motor mode of the request word.
    pub request: Request,
    /// Magnitude of the speed set-point. The drive clamps it to the saturation of its control mode.
    pub speed: ElectricalSpeed,
}

/// Motor mode of REQUEST_WORD, bits 0 to 3 (Table 8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Request {
    /// 0: PWM off.
    #[default]
    Standby,
    /// 1: run forward.
    Drive,
    /// 2: run in reverse.
    Reverse,
    /// 3: commanded shutdown, fault bit 28.
    Shutdown,
}

/// Measurements that need no control tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SlowMeasurements {
    /// Ambient (power board) or external temperature, as selected and calibrated.
    pub temperature: Celsius,
    /// Pressure bridge reading after calibration.
    pub pressure: Volts,
}

/// What the node knows of itself that the fault logic needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Any of fault bits 26, 30 and 31.
    pub store_faults: FaultWord,
    /// A boot or run-time self-test failed: fault bit 27.
    pub self_test_failed: bool,
}

/// The tick's report to the node, every millisecond and at every change of state or fault word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// Tick of this report.
    pub tick: u64,
    /// Exact state, 0 to 7.
    pub state: State,
    /// Live and latched faults (FAULT_WORD).
    pub faults: FaultWord,
    /// Latched critical faults (CRITICAL_FAULT).
    pub critical: FaultWord,
    /// Extended code of the first critical fault; 0 without one.
    pub extended_code: u16,
    /// No valid command for the time-out period.
    pub command_expired: bool,
    /// Why the last start was refused; stays until Standby is requested.
    pub refusal: Refusal,
    /// Bus below 18 V: a diagnostic, not a fault.
    pub supply_low: bool,
    /// Commanded direction.
    pub direction: Direction,
    /// Set-point after saturation and ramp, signed.
    pub setpoint: ElectricalSpeed,
    /// Estimated speed from the hall sensors, signed.
    pub speed_hall: ElectricalSpeed,
    /// Estimated speed from back-EMF, signed; 0 until there is an estimator.
    pub speed_sensorless: ElectricalSpeed,
    /// Electrical angle that the commutation uses.
    pub angle: ElectricalAngle,
    /// Sectors turned since power-up, signed: 6 an electrical revolution.
    pub sectors: i32,
    /// Bus voltage.
    pub bus_voltage: Volts,
    /// Mean DC-link current.
    pub bus_current: Amps,
    /// Electrical input power.
    pub power: Watts,
    /// Terminal voltages.
    pub phase_voltage: [Volts; 3],
    /// Applied duty.
    pub duty: Duty,
    /// What bounds the duty.
    pub limiter: Limiter,
    /// Invalid hall codes (000 or 111) since power-up, saturating.
    pub hall_invalid: u16,
    /// Hall changes between sectors that are not neighbours since power-up, saturating.
    pub hall_jumps: u16,
    /// Result of the last hall calibration.
    pub hall_calibration: HallCalibration,
}

/// Why a Drive request did not start the motor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Refusal {
    /// It was not refused.
    #[default]
    None = 0,
    /// All three control modes are disabled (Table 6).
    NoMode = 1,
    /// The parameter set does not build.
    Parameters = 2,
    /// The selected control mode has no estimator in this firmware.
    NoEstimator = 3,
    /// Standby was not requested since the last stop, fault or reset.
    NoFreshRequest = 4,
}

/// What bounds the duty in this tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Limiter {
    /// The bridge is off.
    #[default]
    Off = 0,
    /// A fixed level: rotor lock or open loop.
    Fixed = 1,
    /// The speed loop.
    Speed = 2,
    /// The bus current limit of Table 11 or the input current rating.
    Current = 3,
    /// The phase current bound.
    PhaseCurrent = 4,
    /// The output power rating.
    Power = 5,
    /// The temperature derating.
    Temperature = 6,
    /// Maximum duty cycle.
    Duty = 7,
    /// The duty's slew limit.
    Slew = 8,
    /// The bus must not be fed: the motor coasts.
    Return = 9,
}

/// Outcome of a hall calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum HallCalibration {
    /// None was run.
    #[default]
    None,
    /// Running now.
    Running,
    /// Order, polarity and offset found.
    Done(HallWiring),
    /// The sensors did not change as three lines of one rotor do, or the two directions disagree.
    Failed,
}

/// How the three hall lines belong to the phases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HallWiring {
    /// Which permutation of the lines, 0..=5; 0 is A, B, C.
    pub order: u8,
    /// Lines to invert: bit 0 = A, bit 1 = B, bit 2 = C, before the permutation.
    pub polarity: u8,
    /// How far the edges lie beyond their place, -32 768..=32 767 for half a turn either way.
    pub offset: i16,
}
