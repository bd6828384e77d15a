//! A driven motor and nothing else, for profilers: the real core in the loop, at 3000 rpm under rated load.
//!
//!     cargo run --release -p narx-sim --example driven -- hall|sensorless TICKS [PRESET]
//!
//! Start and acceleration come first; only `measured` counts (`valgrind --tool=callgrind
//! --toggle-collect=driven::measured`).

use narx_core::commissioning::{Mode, Nameplate};
use narx_core::master::{Config, Master};
use narx_core::motor::State;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::plant::{LoadConfig, PlantConfig};
use narx_sim::presets::preset;
use std::f64::consts::TAU;
use std::process::ExitCode;
use std::time::Instant;

/// Set-point, mechanical rpm.
const RPM: i32 = 3000;

/// The part that counts.
#[inline(never)]
fn measured(bench: &mut Bench, master: &mut Master, ticks: u64) {
    run(bench, master, ticks);
}

/// The drive, its plant, its CAN node and a master that keeps it running. Nothing is recorded or traced.
fn run(bench: &mut Bench, master: &mut Master, ticks: u64) {
    for _ in 0..ticks {
        while let Some(frame) = master.poll_frame(bench.now_ns() / 1000) {
            // Two frames every 50 ms do not fill a queue of 64.
            let _ = bench.send(frame);
        }
        bench.step();
    }
}

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let mode = match arguments.next().as_deref() {
        Some("sensorless") => Mode::Sensorless,
        _ => Mode::Hall,
    };
    let ticks: u64 = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(100_000);
    let name = arguments.next().unwrap_or_else(|| "bly172s-24v".into());
    let Some(preset) = preset(&name) else {
        eprintln!("no preset {name}");
        return ExitCode::FAILURE;
    };
    let speed = f64::from(RPM) * TAU / 60.0;
    let nominal_voltage = preset.data.nominal_voltage;
    let plate = Nameplate {
        motor: preset.motor.figures(),
        rated_current: preset.data.rated_current,
        supply: nominal_voltage,
        open_loop_speed: None,
    };
    let Ok(commissioning) = plate.commission(mode) else {
        eprintln!("{name} cannot be commissioned");
        return ExitCode::FAILURE;
    };
    let mut plant = PlantConfig::new(preset.motor, nominal_voltage);
    plant.load = LoadConfig { quadratic: preset.rated_torque() / (speed * speed), ..LoadConfig::default() };
    plant.angle_deg = 77.0;
    let label = String::new();
    let config = BenchConfig { plant, parameters: commissioning.parameters, label, trace: false };
    let mut bench = Bench::new(&config).without_recording();
    let mut master = Master::new(Config { addresses: bench.node().addresses(), ..Config::default() });
    master.stop();
    run(&mut bench, &mut master, 6_000);
    master.start(RPM);
    run(&mut bench, &mut master, 20_000);
    let before = bench.plant().observe();
    let begun = Instant::now();
    measured(&mut bench, &mut master, ticks);
    let elapsed = begun.elapsed().as_secs_f64();
    let after = bench.plant().observe();
    let simulated = after.time - before.time;
    println!(
        "{:.1} simulated seconds a second: {name}, {mode:?}, {:.2} intervals and {:.2} changes of diodes a tick, {:.0} rpm",
        simulated / elapsed,
        (after.intervals - before.intervals) as f64 / ticks as f64,
        (after.diode_events - before.diode_events) as f64 / ticks as f64,
        (after.angle - before.angle) / simulated * 60.0 / TAU,
    );
    let closed = matches!(bench.status().state, State::HallClosedLoop | State::SensorlessClosedLoop);
    if closed { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
