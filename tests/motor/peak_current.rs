//! Phase current while a heavy rotor accelerates as fast as the limits let it.

use crate::commanded::commanded_tick;
use narx_core::master::{Config, Master};
use narx_core::motor::State;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::commissioning::{Mode, Nameplate};
use narx_sim::plant::{MotorConfig, PlantConfig};
use narx_sim::presets::{PRESETS, Preset};
use xtask::bench::map;

/// 12 A (Table 1) and 5 %.
const PEAK: f64 = 12.6;
/// Ticks of a run at most: boot, and four seconds.
const LONGEST: u32 = 46_000;

/// The worst of the promised plants for the phase current: five times the inertia, so that the limit binds, weak magnets and a cold winding.
/// The largest magnitude of a phase current on the way to full speed, A.
fn peak(preset: &Preset, supply: f64, mode: Mode) -> f64 {
    let sheet = preset.motor;
    let plate =
        Nameplate { motor: sheet, rated_current: preset.data.rated_current, supply, open_loop_speed: None };
    let Ok(commissioning) = plate.commission(mode) else { return 0.0 };
    let motor = MotorConfig {
        inertia: 5.0 * sheet.inertia,
        torque_constant: 0.8 * sheet.torque_constant,
        resistance: 0.9 * sheet.resistance,
        ..sheet
    };
    let mut plant = PlantConfig::new(motor, supply);
    plant.angle_deg = 77.0;
    let mut bench = Bench::new(&BenchConfig {
        plant,
        parameters: commissioning.parameters,
        label: preset.name.into(),
        trace: false,
    })
    .without_recording();
    let mut master = Master::new(Config { addresses: bench.node().addresses(), ..Config::default() });
    master.stop();
    let rpm = 0.95 * commissioning.speed_max;
    let mut peak = 0.0_f64;
    for tick in 0..LONGEST {
        if tick == 6_000 {
            master.start(rpm as i32);
        }
        commanded_tick(&mut bench, &mut master);
        let seen = bench.plant().observe();
        peak = peak.max(seen.peak_current);
        if seen.speed * 60.0 / core::f64::consts::TAU > 0.97 * rpm {
            break;
        }
    }
    assert_ne!(bench.status().state, State::Fault, "{} at {supply} V", preset.name);
    peak
}

/// Commutation takes half of the current and the step makes up for it: what is limited is the mean, and the crest lies a third above it.
#[test]
fn crest_of_a_step_stays_within_the_rating() {
    let mut points = Vec::new();
    for preset in &PRESETS {
        for supply in [36.0, 48.0, 60.0] {
            points.extend([Mode::Hall, Mode::Sensorless].map(|mode| (preset, supply, mode)));
        }
    }
    let peaks = map(&points, |(preset, supply, mode)| peak(preset, *supply, *mode));
    let beyond: Vec<String> = points
        .iter()
        .zip(&peaks)
        .filter(|(_, peak)| **peak > PEAK)
        .map(|((preset, supply, mode), peak)| {
            format!("{} at {supply} V, {}: {peak:.1} A", preset.name, mode.name())
        })
        .collect();
    assert_eq!(beyond, Vec::<String>::new());
    let highest = peaks.iter().copied().fold(0.0, f64::max);
    println!("phase current up to {highest:.2} A");
    // The limit was reached, or this has shown nothing.
    assert!(highest > 11.0, "{highest:.2} A");
}
