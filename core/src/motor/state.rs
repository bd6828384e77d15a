//! The eight states (section 7).

use serde::{Deserialize, Serialize};

/// System states, numbered as the specification numbers them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum State {
    /// 0: boot and self-tests, PWM off.
    #[default]
    Initialization = 0,
    /// 1: PWM off.
    Standby = 1,
    /// 2: holds the rotor at a known position.
    RotorLock = 2,
    /// 3: rotates the field at a commanded speed.
    OpenLoop = 3,
    /// 4: commutates on back-EMF zero crossings.
    SensorlessClosedLoop = 4,
    /// 5: commutates on hall sensors.
    HallClosedLoop = 5,
    /// 6: PWM off until acknowledged.
    Fault = 6,
    /// 7: tries to catch or restart a sensorless motor that has stopped.
    SensorlessAutoRestart = 7,
}
