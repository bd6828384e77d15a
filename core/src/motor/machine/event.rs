//! Events that reach the control tick besides its samples, and the status that it reports back.

pub use crate::motor::control::limits::Limiter;
pub use crate::motor::guard::protection::{Health, SlowMeasurements};
pub use crate::motor::machine::{Command, Refusal, RunRequest};
pub use crate::motor::rotor::hall::HallWiring;
pub use crate::motor::rotor::hall_calibration::HallCalibration;
pub use crate::motor::rotor::zero_crossing::Why;

use super::state::State;
use crate::motor::coefficients::Coefficients;
use crate::motor::commutate::commutation::Direction;
use crate::motor::guard::fault::FaultWord;
use crate::units::{Amps, Duty, ElectricalAngle, ElectricalSpeed, Volts, Watts};
use serde::{Deserialize, Serialize};

/// The node's messages to the tick: at most one is taken at the start of each tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant, reason = "coefficients change owner by moving, rarely; there is no heap")]
pub enum Event {
    /// A valid REQUEST_WORD arrived: feeds the communication time-out; Standby acknowledges a fault.
    Command(Command),
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
    /// A valid MOTOR_CMD arrived: a new set-point magnitude, the request stays. Feeds the time-out,
    /// acknowledges nothing.
    SetPoint(ElectricalSpeed),
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
    /// Reason why the last start was refused; stays until Standby is requested.
    pub refusal: Refusal,
    /// Bus below 18 V: a diagnostic, not a fault.
    pub supply_low: bool,
    /// Commanded direction.
    pub direction: Direction,
    /// Set-point after saturation and ramp, signed, in closed loops and in open loop.
    pub setpoint: ElectricalSpeed,
    /// Estimated speed from the hall sensors, signed.
    pub speed_hall: ElectricalSpeed,
    /// Estimated speed from back-EMF, signed; in open loop the speed of its field.
    pub speed_sensorless: ElectricalSpeed,
    /// Electrical angle that the commutation uses.
    pub angle: ElectricalAngle,
    /// Sectors turned since power-up, signed: 6 an electrical revolution. By the hall sensors, or by the
    /// commutation where they show nothing.
    pub sectors: i32,
    /// The rotor is known to stand.
    pub standstill: bool,
    /// Nothing shows the rotor now: it may turn while `sectors` stands.
    pub unseen: bool,
    /// Bus voltage.
    pub bus_voltage: Volts,
    /// Mean DC-link current.
    pub bus_current: Amps,
    /// Electrical input power.
    pub power: Watts,
    /// Terminal voltages.
    pub phase_voltage: [Volts; 3],
    /// Duty: in the mean over the periods where pulses are left out.
    pub duty: Duty,
    /// The limit that bounds the duty.
    pub limiter: Limiter,
    /// Times that the hall sensors lost their code (000 or 111) since power-up, saturating.
    pub hall_invalid: u16,
    /// Hall changes between sectors that are not neighbours since power-up, saturating.
    pub hall_jumps: u16,
    /// Result of the last hall calibration.
    pub hall_calibration: HallCalibration,
    /// Outcome of the last step's zero crossing.
    pub crossing: Why,
    /// Distance of the last accepted crossing behind its prediction, 65 536 an electrical turn.
    pub crossing_margin: i16,
    /// Zero crossings accepted since power-up, wrapping.
    pub crossings: u32,
}
