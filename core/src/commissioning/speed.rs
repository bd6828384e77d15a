//! The largest speed that the supply allows.

use super::{CONTINUOUS, DUTY_MAX, Nameplate, PEAK, SENSORLESS_PEAK, TWO_PI, VOLTAGE_SHARE};
use core::fmt;
use libm::fmin;

/// The limit that sets the largest speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpeedLimit {
    /// Supply voltage: what the resistance leaves of it is back-EMF there.
    Voltage,
    /// The 12 A peak (Table 1): current ripple leaves room for less than full duty.
    PeakCurrent,
    /// A sector needs two control ticks.
    Ticks,
    /// A sector needs four samples of back-EMF without sensors.
    Samples,
    /// Messages carry measured speeds up to 32,767 rpm.
    Reported,
    /// The largest speed that was asked for.
    Asked,
}

impl SpeedLimit {
    /// Limit that stands behind a largest duty: the peak current if the duty is reduced, else the voltage.
    pub(super) fn of_duty(duty_max: f64) -> Self {
        if duty_max < DUTY_MAX { Self::PeakCurrent } else { Self::Voltage }
    }

    /// Short name: `voltage`, `peak current`, `control ticks`, `samples`, `reported speed`, `asked`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Voltage => "voltage",
            Self::PeakCurrent => "peak current",
            Self::Ticks => "control ticks",
            Self::Samples => "samples",
            Self::Reported => "reported speed",
            Self::Asked => "asked",
        }
    }
}

impl fmt::Display for SpeedLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Voltage => "the supply voltage allows no more",
            Self::PeakCurrent => "the current ripple allows no larger duty below the 12 A peak",
            Self::Ticks => "above that, a sector has fewer than two control ticks",
            Self::Samples => "above that, a sector has fewer than four samples of back-EMF",
            Self::Reported => "messages cannot carry a higher measured speed",
            Self::Asked => "no higher speed was requested",
        })
    }
}

/// Current that the motor must have at its largest speed: constant, and rising with the speed.
pub(super) struct Demand {
    /// Mean current that must fit below the peak beside the ripple, A.
    pub(super) crest: f64,
    /// A.
    constant: f64,
    /// A per rad/s.
    rising: f64,
}

impl Demand {
    /// With a rated current and no largest speed `needed`, A; otherwise what friction takes, and a third of
    /// the rated current to accelerate.
    pub(super) fn new(plate: &Nameplate, needed: f64, asked: Option<f64>) -> Self {
        if plate.rated_current.is_some() && asked.is_none() {
            return Self { crest: needed, constant: needed, rising: 0.0 };
        }
        let m = &plate.motor;
        let constant = m.static_friction / m.torque_constant;
        let rising = m.viscous_friction / m.torque_constant;
        let friction = constant + rising * plate.supply / m.torque_constant;
        // Without sensors the peak is lower.
        let crest = friction + plate.rated_current() / 3.0 + (PEAK - SENSORLESS_PEAK);
        Self { crest: fmin(crest, CONTINUOUS), constant, rising }
    }

    /// Speed at which the supply leaves this current, mechanical rpm: `V D = R I + (k + 3 L I p / 2 pi) w`.
    /// Every commutation costs the volt-seconds that turn the current over, L I / 2 in each of six a
    /// revolution: as if the back-EMF constant were larger.
    pub(super) fn speed(&self, plate: &Nameplate, duty_max: f64) -> f64 {
        let m = &plate.motor;
        let left = VOLTAGE_SHARE * duty_max * plate.supply - m.resistance * self.constant;
        let fastest = self.constant + self.rising * plate.supply / m.torque_constant;
        let turning_over = 3.0 * m.inductance * fastest * f64::from(m.pole_pairs) / TWO_PI;
        left / (m.torque_constant + m.resistance * self.rising + turning_over) * 60.0 / TWO_PI
    }
}
