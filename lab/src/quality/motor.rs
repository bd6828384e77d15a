//! Random motors: not those of the market with deviations, but any motor that a data sheet could describe.

use crate::pwm_rate;
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::motor::Board;
use narx_sim::plant::{BackEmf, MotorConfig};
use narx_sim::presets::{DataSheet, Preset};
use narx_sim::random::Random;
use std::f64::consts::TAU;

/// A motor and its operating conditions.
#[derive(Clone, Debug)]
pub(crate) struct Subject {
    /// Board of the drive.
    pub(crate) board: Board,
    pub(crate) preset: Preset,
    /// Supply voltage, V.
    pub(crate) supply: f64,
    /// Position of the set-point within the promised speeds that the motor allows, 0 to 1 on a logarithmic
    /// scale; `None` for all of [`ELECTRICAL_RPM`].
    pub(crate) place: Option<f64>,
    /// Command that repeats its runs.
    pub(crate) command: String,
}

/// Electrical speeds of the promise: 500 to 4000 rpm with 4 pole pairs.
pub(crate) const ELECTRICAL_RPM: [f64; 4] = [2_000.0, 4_000.0, 8_000.0, 16_000.0];

/// Draws the random motor of a seed for this board. It draws again until commissioning accepts the motor in
/// both modes, at most a thousand times; if none is accepted, there is no motor.
pub(crate) fn random(board: &Board, seed: u64) -> Option<Subject> {
    let mut random = Random::new(seed);
    (0..1_000).find_map(|_| draw(&mut random, board, seed))
}

/// Draws a motor. It follows from its purpose (power, speed, supply) and from ratios that do not depend on
/// size:
///
/// | drawn | from | to | |
/// |---|---|---|---|
/// | rated power | 5 W | 250 W | evenly in the logarithm |
/// | no-load speed | 1000 rpm | 12 000 rpm | logarithm |
/// | supply | 18 V | 60 V | |
/// | loss in the winding at rated torque, of rated power | 5 % | 35 % | |
/// | electrical time constant L / R | 0.15 ms | 2 ms | logarithm |
/// | mechanical time constant J R / k^2 | 2 ms | 60 ms | logarithm |
/// | Coulomb friction, of rated torque | 0.5 % | 8 % | |
/// | viscous friction at no-load speed, of rated torque | 0.5 % | 8 % | |
/// | cogging, of rated torque | 0 | 3 % | |
/// | pole pairs | 1 | 14 | |
/// | back-EMF | sine, or a flat top of 100 to 150 degrees | | |
fn draw(random: &mut Random, board: &Board, seed: u64) -> Option<Subject> {
    let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
    let power = between(5.0_f64.ln(), 250.0_f64.ln()).exp();
    let speed = between(1_000.0_f64.ln(), 12_000.0_f64.ln()).exp() * TAU / 60.0;
    let supply = between(18.0, 60.0);
    let (loss, electrical) = (between(0.05, 0.35), between(0.15e-3_f64.ln(), 2e-3_f64.ln()).exp());
    let mechanical = between(2e-3_f64.ln(), 60e-3_f64.ln()).exp();
    let (coulomb, viscous, cogging) = (between(0.005, 0.08), between(0.005, 0.08), between(0.0, 0.03));
    let pole_pairs = between(1.0, 15.0) as u8;
    let (sine, flat_top_deg) = (between(0.0, 1.0) < 0.5, between(100.0, 150.0));
    let place = between(0.0, 1.0);

    // U = R I + k w at rated torque, with R I = loss U.
    let torque_constant = supply / speed;
    let current = power / supply;
    let resistance = loss * supply / current;
    let torque = torque_constant * current;
    let motor = MotorConfig {
        pole_pairs,
        resistance,
        inductance: electrical * resistance,
        torque_constant,
        inertia: mechanical * torque_constant * torque_constant / resistance,
        static_friction: coulomb * torque,
        viscous_friction: viscous * torque / speed,
        back_emf: if sine { BackEmf::Sinusoidal } else { BackEmf::Trapezoidal { flat_top_deg } },
        cogging_torque: cogging * torque,
        cogging_periods: 6 * u16::from(pole_pairs),
        ..MotorConfig::default()
    };
    let data = DataSheet {
        nominal_voltage: supply,
        no_load_speed: None,
        no_load_current: None,
        rated_speed: None,
        rated_torque: Some(torque),
        rated_current: Some(current),
    };
    let plate =
        Nameplate { motor: motor.figures(), rated_current: Some(current), supply, open_loop_speed: None };
    for mode in [Mode::Hall, Mode::Sensorless] {
        plate.commission_on(board, mode, None).ok()?;
    }
    let preset =
        Preset { name: "random motor", maker: "", part: "", motor, data, sources: &[], estimates: &[] };
    let command = format!("cargo xtask quality --case {seed}{}", pwm_rate::argument(board));
    Some(Subject { board: *board, preset, supply, place: Some(place), command })
}

/// A motor of the market, at its nominal supply.
pub(crate) fn of_market(board: &Board, preset: &Preset) -> Subject {
    Subject {
        board: *board,
        preset: *preset,
        supply: preset.data.nominal_voltage.clamp(18.0, 60.0),
        place: None,
        command: format!("cargo xtask quality --motor {}{}", preset.name, pwm_rate::argument(board)),
    }
}
