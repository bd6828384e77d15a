//! Every preset reaches the operating points that its maker prints.

use crate::driving::Ideal;
use narx_core::motor::Rectification;
use narx_sim::plant::{LoadConfig, Plant, PlantConfig};
use narx_sim::presets::PRESETS;

#[test]
fn every_preset_reaches_its_no_load_point() {
    for preset in &PRESETS {
        let (speed, current) = run(preset, 0.0);
        let data = &preset.data;
        println!(
            "{:20} no load {speed:7.0} rpm {current:6.3} A, printed {:?} rpm {:?} A",
            preset.name, data.no_load_speed, data.no_load_current
        );
    }
}

#[test]
fn every_preset_reaches_its_rated_point() {
    for preset in &PRESETS {
        let data = &preset.data;
        let (speed, current) = run(preset, data.rated_torque.unwrap_or(0.1));
        println!(
            "{:20} rated {speed:7.0} rpm {current:6.3} A, printed {:?} rpm {:?} A",
            preset.name, data.rated_speed, data.rated_current
        );
    }
}

/// Mean speed (rpm) and DC-link current (A) at the nominal voltage and full duty with `torque` on the shaft.
fn run(preset: &narx_sim::presets::Preset, torque: f64) -> (f64, f64) {
    let mut config = PlantConfig::new(preset.motor, preset.data.nominal_voltage);
    config.motor.thermal_resistance = 0.0;
    config.supply.resistance = 0.0;
    config.supply.may_sink = true;
    config.load = LoadConfig { constant: torque, ..LoadConfig::default() };
    config.speed = preset.data.rated_speed.unwrap_or(3000.0) * std::f64::consts::PI / 30.0;
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
    let speed = (end.angle - start.angle) / (end.time - start.time) * 30.0 / std::f64::consts::PI;
    (speed, charge / f64::from(ticks))
}
