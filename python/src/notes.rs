//! Limits of the drive that hold a motor back, in sentences.

use narx_core::commissioning::{Commissioning, SpeedLimit, TorqueLimit};
use narx_core::dictionary::{Dictionary, engineering, number};

/// Share of the no-load speed from which on the supply voltage does not hold a motor back.
const ALL: f64 = 0.9;

/// Returns the notes of commissioning, and the limits of torque and speed that have none there.
pub(crate) fn notes(commissioning: &Commissioning) -> Vec<String> {
    let own = commissioning.notes.iter().map(ToString::to_string);
    own.chain(torque(commissioning)).chain(speed(commissioning)).collect()
}

/// Returns the note of a winding that was hotter than it may be. temperature, max: degrees Celsius. time: s.
pub(crate) fn winding(temperature: f64, time: f64, max: f64) -> Option<String> {
    (temperature > max).then(|| {
        format!(
            "the winding has reached {temperature:.0} degrees Celsius at {time:.1} s, and may have {max:.0}: this motor would \
             be damaged"
        )
    })
}

/// Limits of the drive that allow less torque than the motor's rated current, with the speeds where they do.
fn torque(commissioning: &Commissioning) -> impl Iterator<Item = String> {
    let limits = [TorqueLimit::PhaseCurrent, TorqueLimit::Power, TorqueLimit::BusCurrent];
    limits.into_iter().filter_map(|limit| {
        let mut speeds = commissioning.torque.iter().filter(|point| point.limit == limit).map(|point| point.speed);
        let first = speeds.next()?;
        let (last, rated, name) = (speeds.next_back().unwrap_or(first), commissioning.rated_current, limit.name());
        Some(format!(
            "torque is limited by the drive's {name} from {first:.0} to {last:.0} rpm, not by the motor's rated current of {rated:.1} A"
        ))
    })
}

/// Limit of the speed.
fn speed(commissioning: &Commissioning) -> Option<String> {
    let Commissioning { speed_max, speed_limit, .. } = *commissioning;
    let share = speed_max / no_load_speed(commissioning)?;
    match speed_limit {
        SpeedLimit::Reported => Some(format!("speed is limited to {speed_max:.0} rpm: {speed_limit}")),
        SpeedLimit::Voltage if share < ALL => Some(format!(
            "speed is limited to {speed_max:.0} rpm, {:.0} % of the no-load speed: the winding's current and the reserve of the \
             speed loop take the rest of the supply voltage",
            share * 100.0
        )),
        _ => None,
    }
}

/// Speed at which the back-EMF is the supply voltage, rpm; `None` if its constant is 0.
fn no_load_speed(commissioning: &Commissioning) -> Option<f64> {
    let value = |number| {
        let row = Dictionary::row(number)?;
        Some(engineering::to_unit(row, commissioning.parameters.value(number)?.into()))
    };
    let speed = value(number::NOMINAL_SUPPLY)? / value(number::BACK_EMF_CONSTANT)?;
    speed.is_finite().then_some(speed)
}
