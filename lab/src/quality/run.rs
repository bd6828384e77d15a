//! Runs of a motor in a mode: steady running without and with load, and a load step.

use super::motor::{ELECTRICAL_RPM, Subject};
use super::physics::{Hidden, Plunge};
use crate::promises::load_step;
use crate::promises::{Figures, Point};
use narx_core::commissioning::Mode;

/// Control modes with a closed loop.
pub(super) const MODES: [Mode; 2] = [Mode::Hall, Mode::Sensorless];

/// A metric of CONTROL's promises: name, unit, bound, and its value in the figures of a run.
pub(super) struct Metric {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) most: f64,
    pub(super) of: fn(&Figures) -> f64,
}

/// All metrics of steady running.
pub(super) const METRICS: [Metric; 6] = [
    Metric { name: "Drive request to closed loop", unit: "s", most: 0.8, of: |f| f.to_closed_loop },
    Metric { name: "steady speed error, mean", unit: "%", most: 0.5, of: |f| 100.0 * f.error.abs() },
    Metric { name: "jitter of commutation, rms of a period", unit: "%", most: 2.0, of: |f| 100.0 * f.jitter },
    Metric { name: "commutation angle, mean", unit: "deg", most: 2.0, of: |f| f.angle_mean.abs() },
    Metric { name: "commutation angle, furthest", unit: "deg", most: 5.0, of: |f| f.angle_worst.abs() },
    Metric { name: "phase current, peak", unit: "A", most: 12.6, of: |f| f.peak_current },
];

/// Result of a run at a point.
pub(super) enum Outcome {
    /// The drive's limits do not allow the point: nothing was run.
    Limited(String),
    /// Figures of steady running.
    Steady(Figures),
    /// Time until the speed had recovered from a load step, s.
    Step(f64),
    /// The motor did not start or did not reach its speed, or lost synchronism in a load step.
    Lost(String),
}

/// Time from the set-point to the measurement, s: under a heavy load at low speed the last per cent takes
/// this long (`physics.rs`).
const SETTLE: f64 = 3.0;

/// One run.
pub(super) struct Run {
    pub(super) mode: Mode,
    /// True if physics leaves no usable signal to a drive without sensors: such runs are judged apart.
    pub(super) unseen: bool,
    /// Description: motor, mode, supply, speed and load.
    pub(super) what: String,
    pub(super) outcome: Outcome,
    pub(super) command: String,
}

/// Runs everything for a motor.
pub(super) fn runs(subject: &Subject) -> Vec<Run> {
    let mut runs = Vec::new();
    for mode in MODES {
        for load in [0.0, 1.0] {
            let speeds = match subject.place {
                None => ELECTRICAL_RPM.to_vec(),
                Some(place) => vec![set_point(subject, mode, load, place)],
            };
            runs.extend(speeds.into_iter().map(|electrical| steady(subject, mode, load, electrical)));
        }
        runs.push(step(subject, mode));
    }
    runs
}

/// Electrical rpm at a position between the slowest promised speed and the fastest that is promised and that
/// the motor's limits allow.
fn set_point(subject: &Subject, mode: Mode, load: f64, place: f64) -> f64 {
    let poles = f64::from(subject.preset.motor.pole_pairs);
    let most = point(subject, mode, load, None).speed_max().unwrap_or(f64::INFINITY) * poles;
    let [low, .., high] = ELECTRICAL_RPM;
    low * (most.clamp(low, high) / low).powf(place)
}

fn point(subject: &Subject, mode: Mode, load: f64, rpm: Option<f64>) -> Point<'_> {
    Point { board: subject.board, preset: &subject.preset, mode, supply: subject.supply, load, rpm }
}

fn steady(subject: &Subject, mode: Mode, load: f64, electrical: f64) -> Run {
    let rpm = (electrical / f64::from(subject.preset.motor.pole_pairs)).ceil();
    let point = point(subject, mode, load, Some(rpm));
    let mut what = format!(
        "{} {}, {:.1} V, {rpm} rpm, {:.0} % load",
        subject.preset.name,
        mode.name(),
        subject.supply,
        100.0 * load
    );
    let (outcome, unseen) = match point.plan() {
        Err(why) => (Outcome::Limited(why), false),
        Ok(plan) => {
            let hidden = Hidden::new(&subject.board, &subject.preset.motor, plan.torque, f64::from(plan.rpm));
            what += &format!(", the floating phase conducts for {:.0} degrees", hidden.degrees);
            let outcome = point.run_after(SETTLE).map_or_else(Outcome::Lost, Outcome::Steady);
            (outcome, mode == Mode::Sensorless && hidden.is_crossing())
        }
    };
    Run { mode, unseen, what, outcome, command: subject.command.clone() }
}

/// Runs a load step from no load to rated torque at once, in the middle of the range.
fn step(subject: &Subject, mode: Mode) -> Run {
    let point = point(subject, mode, 1.0, None);
    let mut what = format!("{} {}, {:.1} V, load step", subject.preset.name, mode.name(), subject.supply);
    let (outcome, unseen) = match point.plan() {
        Err(why) => (Outcome::Limited(why), false),
        Ok(plan) => {
            let plunge = Plunge::new(&subject.preset.motor, plan.torque, f64::from(plan.rpm));
            what += &format!(
                " at {} rpm that takes {:.0} % of the speed at first",
                plan.rpm,
                100.0 * plunge.share
            );
            let outcome = load_step::step(&point).map_or_else(Outcome::Lost, Outcome::Step);
            (outcome, mode == Mode::Sensorless && plunge.is_deep())
        }
    };
    Run { mode, unseen, what, outcome, command: subject.command.clone() }
}
