//! Tests that every preset reaches the operating points of its data sheet.

use crate::driving::Ideal;
use narx_core::motor::Rectification;
use narx_sim::plant::{LoadConfig, Plant, PlantConfig};
use narx_sim::presets::PRESETS;
use std::f64::consts::PI;

/// Tolerances. Published speeds and currents of the maxon motors are typical values; the plant adds 0.04 ohm
/// of switches and, for a sinusoidal motor, the ripple of block commutation. The rated points of the flat
/// motors are thermal limits beside the straight line through the no-load point, hence their wider tolerance.
/// Windings are at 25 degrees Celsius.
const NO_LOAD_SPEED: f64 = 0.01;
const NO_LOAD_CURRENT: f64 = 0.05;
const RATED_SPEED: f64 = 0.05;
const RATED_CURRENT: f64 = 0.03;

/// Motors whose published rated point is a thermal rating, not the point that they reach at full voltage and
/// 25 degrees Celsius: 3980 rpm of the first would take 5.6 V in 0.46 ohm at 3.33 A. The point must be within
/// reach. Of the last motor only the torque is published; its rated current is an estimate, 10 % above the
/// plant's.
const RATED_BY_HEAT: [&str; 5] =
    ["4221g018bxth-18v", "4221g024bxth-24v", "qbl5704-36v", "bldc-1-25-058-201-24v", "ec-i40-100w-48v"];

#[test]
fn every_preset_reaches_its_no_load_point() {
    for preset in &PRESETS {
        let (speed, current) = run(preset, 0.0);
        let data = &preset.data;
        println!(
            "{:20} no load {speed:7.0} rpm {current:6.3} A, printed {:?} rpm {:?} A",
            preset.name, data.no_load_speed, data.no_load_current
        );
        near(preset.name, speed, data.no_load_speed, NO_LOAD_SPEED);
        near(preset.name, current, data.no_load_current, NO_LOAD_CURRENT);
    }
}

#[test]
fn every_preset_reaches_its_rated_point() {
    for preset in &PRESETS {
        let data = &preset.data;
        // Without a published torque: the torque of the rated current.
        let friction = 2.0 * preset.motor.static_friction;
        let by_current = preset.motor.torque_constant * data.rated_current.unwrap_or(0.0) - friction;
        let torque = data.rated_torque.unwrap_or(by_current);
        let (speed, current) = run(preset, torque);
        println!(
            "{:20} rated {speed:7.0} rpm {current:6.3} A, printed {:?} rpm {:?} A",
            preset.name, data.rated_speed, data.rated_current
        );
        if data.rated_torque.is_some()
            && data.rated_current.is_some()
            && !RATED_BY_HEAT.contains(&preset.name)
        {
            near(preset.name, speed, data.rated_speed, RATED_SPEED);
            near(preset.name, current, data.rated_current, RATED_CURRENT);
        } else {
            // A rating, not a point on the line at full voltage: it must be within reach.
            assert!(speed > 0.98 * data.rated_speed.unwrap_or(0.0), "{}: {speed} rpm", preset.name);
        }
    }
}

#[test]
fn every_figure_of_a_preset_has_a_source_or_an_estimate() {
    for preset in &PRESETS {
        assert!(!preset.sources.is_empty() && !preset.estimates.is_empty(), "{}", preset.name);
        assert_eq!(narx_sim::presets::preset(preset.name), Some(preset));
        let motor = &preset.motor;
        // The friction follows from the no-load current, published or estimated.
        let rpm = preset.data.no_load_speed.or(preset.data.rated_speed);
        let rpm = rpm.unwrap_or_else(|| preset.data.nominal_voltage / motor.torque_constant * 30.0 / PI);
        let torque = motor.static_friction + motor.viscous_friction * rpm * PI / 30.0;
        let current = torque / motor.torque_constant;
        let printed = preset.data.no_load_current.unwrap_or_else(|| match preset.name {
            "ec-max40-120w-48v" => 4.06 - 0.17 / 0.0448,
            _ => 0.08 * preset.data.rated_current.unwrap(),
        });
        assert!((current / printed - 1.0).abs() < 0.01, "{}: {current} A", preset.name);
        // The mechanical time constant J R / k^2 is typical of such motors.
        let time = motor.inertia * motor.resistance / motor.torque_constant.powi(2);
        assert!((0.0005..0.05).contains(&time), "{}: {time} s", preset.name);
    }
    assert!(PRESETS.iter().any(|preset| preset.motor.pole_pairs == 1));
    assert!(PRESETS.iter().any(|preset| preset.motor.pole_pairs == 12));
}

fn near(name: &str, found: f64, printed: Option<f64>, tolerance: f64) {
    if let Some(printed) = printed {
        let off = found / printed - 1.0;
        assert!(off.abs() < tolerance, "{name}: {found}, printed {printed}: {:.1} % off", 100.0 * off);
    }
}

/// Mean speed (rpm) and DC-link current (A) at the nominal voltage and full duty with `torque` on the shaft.
fn run(preset: &narx_sim::presets::Preset, torque: f64) -> (f64, f64) {
    let mut config = PlantConfig::new(preset.motor, preset.data.nominal_voltage);
    config.motor.thermal_resistance = 0.0;
    config.supply.resistance = 0.0;
    config.supply.may_sink = true;
    config.load = LoadConfig { constant: torque, ..LoadConfig::default() };
    config.speed = preset.data.rated_speed.unwrap_or(3000.0) * PI / 30.0;
    let mut plant = Plant::new(&config);
    let ideal = Ideal { rectification: Rectification::Diode, ..Ideal::forward(1.0) };
    ideal.run(&mut plant, 1.0);
    let start = plant.observe();
    let mut charge = 0.0;
    let ticks = 5000;
    for _ in 0..ticks {
        plant.sample();
        let command = ideal.command(&plant.observe(), &plant);
        plant.finish_period(&command);
        charge += plant.observe().bus_current;
    }
    let end = plant.observe();
    let speed = (end.angle - start.angle) / (end.time - start.time) * 30.0 / PI;
    (speed, charge / f64::from(ticks))
}
