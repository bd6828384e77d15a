//! The load that a commissioned motor can have at each speed.

use super::{CONTINUOUS, Design, Nameplate, TORQUE_POINTS, TWO_PI, VOLTAGE_SHARE, least};
use crate::dictionary::engineering;
use crate::dictionary::{Parameters, number};
use crate::motor::control::limits::power_rating;
use crate::units::Volts;
use core::fmt;
use libm::{fmax, fmin, sqrt};

/// Continuous torque at a speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorquePoint {
    /// Mechanical rpm.
    pub speed: f64,
    /// At the shaft, beside the motor's own friction, N m; 0 where friction takes all.
    pub torque: f64,
    /// The limit that sets it.
    pub limit: TorqueLimit,
}

/// The limit of the continuous torque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TorqueLimit {
    /// The motor's rated current.
    RatedCurrent,
    /// The drive's phase current, 6 A (Table 2) or less.
    PhaseCurrent,
    /// The drive's output power (Table 1).
    Power,
    /// The drive's bus current, 6 A (parameter 106).
    BusCurrent,
    /// The supply voltage.
    Voltage,
}

impl TorqueLimit {
    /// Short name: `rated current`, `phase current`, `power`, `bus current`, `voltage`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::RatedCurrent => "rated current",
            Self::PhaseCurrent => "phase current",
            Self::Power => "power",
            Self::BusCurrent => "bus current",
            Self::Voltage => "voltage",
        }
    }
}

impl fmt::Display for TorqueLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

pub(super) fn points(
    plate: &Nameplate,
    design: &Design,
    parameters: &Parameters,
) -> [TorquePoint; TORQUE_POINTS] {
    let bus_current = engineering::value(parameters, number::HV_CURRENT_MAX).unwrap_or(0.0);
    let step = (design.speed_max - design.speed_min) / (TORQUE_POINTS - 1) as f64;
    core::array::from_fn(|number| point(plate, design, bus_current, design.speed_min + number as f64 * step))
}

/// `T = k I - Ts - B w` with the least current of every limit.
fn point(plate: &Nameplate, design: &Design, bus_current: f64, speed: f64) -> TorquePoint {
    let m = &plate.motor;
    let w = speed * TWO_PI / 60.0;
    let emf = m.torque_constant * w;
    // V D = R I + k w + 3 L I p w / 2 pi, as for the largest speed.
    let turning_over = 3.0 * m.inductance * f64::from(m.pole_pairs) / TWO_PI * w;
    let by_voltage = (VOLTAGE_SHARE * design.duty_max * plate.supply - emf) / (m.resistance + turning_over);
    // P = R I^2 + k w I.
    let by_power = |power: f64| (sqrt(emf * emf + 4.0 * m.resistance * power) - emf) / (2.0 * m.resistance);
    let rating = power_rating(Volts::from_milli((plate.supply * 1e3) as i32));
    let limits = [
        (plate.rated_current(), TorqueLimit::RatedCurrent),
        (fmin(design.phase_current, CONTINUOUS), TorqueLimit::PhaseCurrent),
        (by_power(f64::from(rating)), TorqueLimit::Power),
        (by_power(bus_current * plate.supply), TorqueLimit::BusCurrent),
        (by_voltage, TorqueLimit::Voltage),
    ];
    let (current, limit) = least(&limits);
    let torque = fmax(m.torque_constant * current - m.static_friction - m.viscous_friction * w, 0.0);
    TorquePoint { speed, torque, limit }
}
