//! Measures how fast the plant runs: `cargo run --release -p narx-sim --example plant_speed -- SECONDS`.

use narx_core::motor::commutate::commutation::sector_of;
use narx_core::motor::{Direction, PwmCommand, Rectification, Step};
use narx_core::units::{Duty, ElectricalAngle};
use narx_sim::plant::{Plant, PlantConfig};
use narx_sim::presets::PRESETS;
use std::time::Instant;

fn main() {
    for preset in &PRESETS {
        for rectification in [Rectification::Diode, Rectification::Synchronous] {
            let mut plant = Plant::new(&PlantConfig::new(preset.motor, preset.data.nominal_voltage));
            let seconds = std::env::args().nth(1).and_then(|text| text.parse().ok()).unwrap_or(5u32);
            let started = Instant::now();
            for _ in 0..seconds * 10_000 {
                plant.sample();
                let turns = plant.observe().electrical_turns;
                let angle = ElectricalAngle((turns.rem_euclid(1.0) * 65_536.0) as u16);
                plant.finish_period(&PwmCommand {
                    duty: Duty::from_bits(20_000),
                    rectification,
                    sample_at: 1000,
                    step: Step::for_sector(sector_of(angle), Direction::Forward),
                    ..PwmCommand::default()
                });
            }
            let elapsed = started.elapsed().as_secs_f64();
            let seen = plant.observe();
            println!(
                "{:20} {rectification:?}: {:.0} simulated seconds a second, {:.2} intervals a tick, {:.0} rad/s",
                preset.name,
                f64::from(seconds) / elapsed,
                seen.intervals as f64 / f64::from(seconds * 10_000),
                seen.speed
            );
        }
    }
}
