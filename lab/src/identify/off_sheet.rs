//! Worth of an identification: motors that are not as their data sheet says, commissioned from the truth,
//! from the sheet, and from what the drive has measured.

use super::Trial;
use crate::quality::motor::{self, Subject};
use narx_core::commissioning::{Commissioning, Mode, Motor, Nameplate, WRITTEN};
use narx_core::dictionary::engineering;
use narx_core::motor::Board;
use narx_host::parallel::map;
use narx_sim::experiment::{Experiment, Outcome};
use narx_sim::plant::{LoadConfig, MotorConfig};
use narx_sim::random::Random;
use narx_sim::session::SessionConfig;

/// Torque of the load, share of the rated torque.
const LOAD: f64 = 0.2;
/// Length of a start, s.
const SECONDS: f64 = 4.0;
/// Largest error of the speed at its end, share of the set-point.
const HOLDS: f64 = 0.005;

/// Sources of the parameters.
const SOURCES: [&str; 3] = ["true data", "data sheet", "identification"];

/// Measures this many motors, and prints a table of those that were identified, and one of the others.
pub(super) fn run(board: &Board, motors: u64) {
    let seeds: Vec<u64> = (0..motors).collect();
    let all: Vec<Starts> = map(&seeds, |seed| one(board, *seed)).into_iter().flatten().collect();
    let (identified, others): (Vec<Starts>, Vec<Starts>) =
        all.into_iter().partition(|starts| starts.identified);
    for (what, motors) in [("identified", identified), ("not identified", others)] {
        let starts: Vec<[Option<f64>; SOURCES.len()]> = motors.iter().flat_map(|motor| motor.times).collect();
        println!("{} motors {what}, {} sensorless starts", motors.len(), starts.len());
        for (place, name) in SOURCES.into_iter().enumerate() {
            let mut times: Vec<f64> = starts.iter().filter_map(|times| times[place]).collect();
            let share = 100.0 * times.len() as f64 / starts.len().max(1) as f64;
            println!(
                "{name:16} {share:5.1} % hold their speed; time to it: {}",
                super::spread(&mut times, " s")
            );
        }
    }
}

/// Starts of one motor.
struct Starts {
    identified: bool,
    /// By set-point and source: time to speed, s, if the speed was reached and held.
    times: [[Option<f64>; SOURCES.len()]; 2],
}

/// Runs one motor; `None` if the drive cannot run it even with its true data.
fn one(board: &Board, seed: u64) -> Option<Starts> {
    let sheet = motor::random(board, seed)?;
    let mut random = Random::new(seed ^ 0x0ff5);
    let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
    let m = sheet.preset.motor;
    let made = MotorConfig {
        resistance: m.resistance * between(0.7, 1.7),
        torque_constant: m.torque_constant * between(0.7, 1.2),
        inertia: m.inertia * between(0.2_f64.ln(), 5.0_f64.ln()).exp(),
        ..m
    };
    let subject =
        Subject { preset: narx_sim::presets::Preset { motor: made, ..sheet.preset }, ..sheet.clone() };
    let rated = sheet.preset.data.rated_current;
    let commission = |motor: Motor, rated_current| {
        let plate = Nameplate { motor, rated_current, supply: sheet.supply, open_loop_speed: None };
        plate.commission_on(board, Mode::Sensorless, None).ok()
    };
    let truth = commission(made.figures(), rated)?;
    let trial = Trial::run(board, &subject, seed);
    let found = trial.outcome.and_then(Result::ok);
    let measured = found.and_then(|found| commission(found.motor()?, None));
    let sources = [Some(truth.clone()), commission(m.figures(), rated), measured];
    // Both are well within the range of the true motor.
    let setpoints = [1.3 * truth.speed_min, (truth.speed_min * truth.speed_max).sqrt()];
    let times = setpoints
        .map(|rpm| sources.each_ref().map(|source| start(board, &subject, source.as_ref()?, rpm, seed)));
    Some(Starts { identified: found.is_some(), times })
}

/// A start with these parameters: time to speed, s, if the speed is reached and held.
fn start(board: &Board, subject: &Subject, set: &Commissioning, rpm: f64, seed: u64) -> Option<f64> {
    let values = WRITTEN
        .into_iter()
        .filter_map(|number| Some((number, engineering::value(&set.parameters, number)?)))
        .collect();
    let torque = subject.preset.data.rated_torque.unwrap_or(0.0);
    let session = SessionConfig {
        board: *board,
        rated_current: subject.preset.data.rated_current,
        load: LoadConfig { constant: LOAD * torque, ..LoadConfig::default() },
        parameters: values,
        seed,
        trace: false,
        ..SessionConfig::new(subject.preset.motor, subject.supply, Mode::Sensorless)
    };
    let experiment = Experiment { session, rpm: Some(rpm as i32), seconds: SECONDS, fault: None };
    let (figures, _) = experiment.run(|| true).ok()??;
    let holds =
        figures.outcome == Outcome::Running && figures.speed_error.abs() < HOLDS && figures.attempts == 1;
    holds.then_some(figures.time_to_speed)
}
