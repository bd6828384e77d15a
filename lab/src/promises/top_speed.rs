//! The promise about top speed, with sampled back-EMF and with time-stamped edges. A sector needs samples or
//! ticks, so the promised speed is in proportion to the PWM rate.

use super::Context;
use super::trial::Trial;
use narx_core::commissioning::{Commissioning, Mode, Nameplate};
use narx_core::dictionary::engineering;
use narx_core::dictionary::number;
use narx_core::motor::{Board, State};
use narx_report::figures::{Figure, Part};
use narx_sim::plant::{ComparatorConfig, LoadConfig, MotorConfig, PlantConfig};
use narx_sim::presets::preset;
use std::f64::consts::TAU;

/// Supply of the runs, V: far from the over-voltage threshold, which other promises concern.
const SUPPLY: f64 = 48.0;
/// Highest supply of the drive (Table 2), V.
const MOST: f64 = 60.0;

/// A motor that reaches 60 000 electrical rpm at this supply.
fn motor() -> MotorConfig {
    MotorConfig {
        torque_constant: 0.025,
        inductance: 5e-4,
        resistance: 0.6,
        static_friction: 0.002,
        ..MotorConfig::default()
    }
}

/// Torque of the fan on the shaft at 50 000 electrical rpm, N m.
const FAN: f64 = 0.005;

/// Delay of the comparators, s.
const DELAY: f64 = 2e-6;

/// Set-points that are tried, electrical rpm.
const SPEEDS: [i32; 11] =
    [16_000, 20_000, 24_000, 26_000, 28_000, 30_000, 36_000, 42_000, 46_000, 50_000, 52_000];
/// Those with time-stamped edges.
const EDGE_SPEEDS: [i32; 7] = [24_000, 30_000, 36_000, 42_000, 46_000, 50_000, 52_000];
/// Promised electrical revolutions per minute for each hertz of the PWM rate: 24 000 and 50 000 at 10 kHz.
const SAMPLED: f64 = 2.4;
const EDGES: f64 = 5.0;
/// Revolutions for the highest set-point that is tried with sampled back-EMF: 3.3 samples a sector.
const SAMPLED_MAX: f64 = 3.0;
/// Largest promised speed, electrical rpm: the motor reaches little more at this supply.
const PROMISED_MAX: f64 = 50_000.0;

/// Searches for the highest set-point that is held within 0.5 %, in steps.
pub(super) fn part(context: &Context<'_>) -> Part {
    let board = context.board;
    let rate = f64::from(board.tick_rate);
    let tried: Vec<i32> = SPEEDS.into_iter().filter(|rpm| f64::from(*rpm) <= SAMPLED_MAX * rate).collect();
    let mut part = Part::default();
    for (name, least, (speed, why)) in [
        ("top speed, sampled back-EMF", SAMPLED, highest(&board, false, &tried)),
        ("top speed, time-stamped edges", EDGES, highest(&board, true, &EDGE_SPEEDS)),
    ] {
        let least = (least * rate).min(PROMISED_MAX);
        let figure = Figure::new(name, f64::from(speed), "electrical rpm").at_least(least);
        if !figure.is_met() {
            part.failures.extend(why);
        }
        part.figures.push(figure.note("held within 0.5 %, a fan on the shaft"));
    }
    let Some(sibling) = preset("ec45-flat-50w-18v") else {
        part.failures.push("no preset ec45-flat-50w-18v".into());
        return part;
    };
    for (edges, name) in [(false, "sampled back-EMF"), (true, "time-stamped edges")] {
        for (share, of) in [(1.0 / 3.0, "a third of the rated torque"), (1.0, "the rated torque")] {
            let (motor, torque) = (flat(sibling.motor), share * FLAT_CURRENT * FLAT_CONSTANT);
            let run = Run { motor, rated_current: FLAT_CURRENT, supply: MOST, torque };
            let name = format!("top speed of a maxon EC 45 flat, {name}");
            let figure = Figure::new(&name, f64::from(run.highest(&board, edges)), "electrical rpm");
            part.figures.push(figure.note(format!("held within 0.5 % through a step to {of}")));
        }
        if board.tick_rate < OUTRUNNER_RATE {
            continue;
        }
        let (least, supply, torque) = if edges { (3.0, 54.0, 0.22) } else { (2.5, 51.0, 0.28) };
        let run = Run { motor: outrunner(sibling.motor), rated_current: 6.0, supply, torque };
        let name = format!("top speed of a T-Motor U8, {name}");
        let (held, least) = (run.highest(&board, edges), (least * rate).min(OUTRUNNER_MOST));
        let figure = Figure::new(&name, f64::from(held), "electrical rpm").at_least(least);
        let figure = figure.note(format!("held within 0.5 % through a step to {torque} N m, {supply} V"));
        if !figure.is_met() {
            part.failures.push(format!("{name}: {held} electrical rpm are held, {least} are promised"));
        }
        part.figures.push(figure);
    }
    part
}

/// A motor from the market and its load.
struct Run {
    motor: MotorConfig,
    rated_current: f64,
    supply: f64,
    /// Of the step, N m.
    torque: f64,
}

impl Run {
    /// Returns the last set-point that was held through the step, electrical rpm.
    fn highest(&self, board: &Board, edges: bool) -> i32 {
        let per_tick = if edges { 0.4 } else { 0.3 };
        let most = (per_tick * f64::from(board.tick_rate) * 10.0) as i32;
        let speeds = (2..=15).map(|step| step * 10_000).take_while(|speed| *speed <= most);
        let held = speeds.take_while(|speed| self.hold_through_step(board, edges, *speed).is_ok());
        held.last().unwrap_or(0)
    }

    fn hold_through_step(&self, board: &Board, edges: bool, electrical: i32) -> Result<(), String> {
        let supplied = (self.motor, Some(self.rated_current), self.supply);
        let mut trial = settle(board, supplied, edges, electrical, LoadConfig::default())?;
        judge(&mut trial, electrical)?;
        trial.bench.plant_mut().set_load(LoadConfig { constant: self.torque, ..LoadConfig::default() });
        trial.run_while(1.0, |_| true);
        judge(&mut trial, electrical)
    }
}

/// Returns the last set-point that was held, and the reason why the next was not.
fn highest(board: &Board, edges: bool, speeds: &[i32]) -> (i32, Option<String>) {
    let motor = motor();
    let mut held = 0;
    for electrical in speeds {
        match hold(board, motor, edges, *electrical) {
            Ok(()) => held = *electrical,
            Err(why) => return (held, Some(format!("{electrical} electrical rpm: {why}"))),
        }
    }
    (held, None)
}

/// maxon EC 45 flat 50 W, 339285: a winding with 380 rpm a volt (github vhsabino/MATLAB,
/// PIDMaxon/constants.m; 8 pole pairs, friction and cogging of its sibling among the presets). Its bearings
/// are made for 10 000 rpm: the run is a test of the drive, and no advice.
fn flat(sibling: MotorConfig) -> MotorConfig {
    MotorConfig { resistance: 0.464, inductance: 3.22e-4, torque_constant: FLAT_CONSTANT, ..sibling }
}

/// Its torque constant, N m/A, and the rated current of its sibling, A.
const FLAT_CONSTANT: f64 = 0.0251;
const FLAT_CURRENT: f64 = 3.68;

/// T-Motor U8 KV150, an outrunner for large propellers: 21 pole pairs, 150 rpm a volt, 86 mohm and 40 uH
/// line to line (github EelcoHoogendoorn/pypowertrain, of the page u8-v2-u-efficiency-kv150 of
/// store.tmotor.com). Estimated: the inertia, of 80 g of its 273 g at a radius of 35 mm, and the friction, of
/// 0.3 A without load; the rest is as of the other motor. Its load is what the ripple of 40 uH leaves of the
/// drive's 6 A: 140 W at 100 000 electrical rpm, 164 W at 150 000.
fn outrunner(sibling: MotorConfig) -> MotorConfig {
    MotorConfig {
        resistance: 0.086,
        inductance: 4e-5,
        torque_constant: 60.0 / TAU / 150.0,
        inertia: 1e-4,
        pole_pairs: 21,
        static_friction: 0.01,
        viscous_friction: 2e-5,
        cogging_torque: 0.0,
        ..sibling
    }
}

/// Least PWM rate for it, Hz: at a lower one the ripple takes the drive's whole current.
const OUTRUNNER_RATE: u32 = 40_000;
/// Highest set-point that is asked of it, electrical rpm.
const OUTRUNNER_MOST: f64 = 150_000.0;

/// Holds a set-point with a fan on the shaft.
fn hold(board: &Board, motor: MotorConfig, edges: bool, electrical: i32) -> Result<(), String> {
    let full = 50_000.0 / f64::from(motor.pole_pairs) / 60.0 * TAU;
    let load = LoadConfig { quadratic: FAN / (full * full), ..LoadConfig::default() };
    let mut trial = settle(board, (motor, None, SUPPLY), edges, electrical, load)?;
    judge(&mut trial, electrical)
}

/// A motor with its rated current (A) and supply (V).
type Supplied = (MotorConfig, Option<f64>, f64);

/// Starts a motor and waits until it has its speed.
fn settle(
    board: &Board,
    (motor, rated_current, supply): Supplied,
    edges: bool,
    electrical: i32,
    load: LoadConfig,
) -> Result<Trial, String> {
    let rpm = electrical / i32::from(motor.pole_pairs);
    let commissioning = commission(board, (motor, rated_current, supply), edges, rpm)?;
    let mut plant = PlantConfig::new(motor, supply);
    plant.board = Board { comparator_capture: edges, ..*board };
    plant.comparator = edges.then_some(ComparatorConfig { delay: DELAY, hysteresis: 0.1 });
    plant.load = load;
    let mut trial = Trial::new(&plant, &commissioning, "", false);
    trial.start(rpm);
    let closed = |trial: &Trial| trial.state() == State::SensorlessClosedLoop;
    trial.until(5.0, closed).ok_or("no closed loop")?;
    trial.run_while(3.0, |_| true);
    Ok(trial)
}

/// The speed has to be within 0.5 % of the set-point, in closed loop.
fn judge(trial: &mut Trial, electrical: i32) -> Result<(), String> {
    let rpm = electrical / i32::from(trial.bench.plant().config().motor.pole_pairs);
    let mean = trial.mean_rpm(0.5);
    if trial.state() != State::SensorlessClosedLoop {
        let status = trial.bench.status();
        return Err(format!("{}, code {:#06x}", status.state.name(), status.extended_code));
    }
    let error = mean / f64::from(rpm) - 1.0;
    if error.abs() > 0.005 {
        let limiter = trial.bench.status().limiter;
        return Err(format!("{:.2} % off, bounded by {limiter:?}", 100.0 * error));
    }
    Ok(())
}

/// Commissions the motor with the largest set-point raised to `rpm`: commissioning alone would keep four
/// samples a sector.
fn commission(
    board: &Board,
    (motor, rated_current, supply): Supplied,
    edges: bool,
    rpm: i32,
) -> Result<Commissioning, String> {
    let plate = Nameplate { motor: motor.figures(), rated_current, supply, open_loop_speed: None };
    let commissioning = plate.commission_on(board, Mode::Sensorless, None);
    let mut commissioning = commissioning.map_err(|error| error.to_string())?;
    let mut set = |number, value| {
        engineering::set(&mut commissioning.parameters, number, value).map_err(|error| error.to_string())
    };
    if f64::from(rpm) > commissioning.speed_max {
        set(number::SPEED_MAX_SL, f64::from(rpm))?;
    }
    if edges {
        // The comparators' 2 us, in ticks.
        set(number::ZC_DELAY, DELAY * f64::from(board.tick_rate))?;
    }
    Ok(commissioning)
}
