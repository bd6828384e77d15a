//! Tests of the phase current while a heavy rotor accelerates as fast as the limits allow.

use crate::commanded::commanded_tick;
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::master::{Config, Master};
use narx_core::motor::State;
use narx_host::parallel::map;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::plant::{MotorConfig, PlantConfig};
use narx_sim::presets::{PRESETS, Preset};

/// Largest peak, A: 12 A (Table 1) and 5 %, for a motor as in its data sheet.
const PEAK: f64 = 12.6;
/// Largest peak with weak magnets and a cold winding, A: 12 A and 8 %.
const PEAK_OFF_THE_SHEET: f64 = 12.96;
/// Longest run, ticks: boot, and four seconds.
const LONGEST: u32 = 46_000;

/// A start of a rotor that rests at `angle_deg`.
#[derive(Clone, Copy)]
struct Start {
    preset: &'static Preset,
    supply: f64,
    mode: Mode,
    angle_deg: f64,
    off_the_sheet: bool,
}

impl Start {
    /// Largest magnitude of a phase current on the way to full speed, A. The rotor has five times its
    /// inertia, so that the limit acts.
    fn peak(self) -> f64 {
        let Self { preset, supply, mode, angle_deg, off_the_sheet } = self;
        let sheet = preset.motor;
        let plate = Nameplate {
            motor: sheet.figures(),
            rated_current: preset.data.rated_current,
            supply,
            open_loop_speed: None,
        };
        let Ok(commissioning) = plate.commission(mode) else { return 0.0 };
        let (magnets, winding) = if off_the_sheet { (0.8, 0.9) } else { (1.0, 1.0) };
        let motor = MotorConfig {
            inertia: 5.0 * sheet.inertia,
            torque_constant: magnets * sheet.torque_constant,
            resistance: winding * sheet.resistance,
            ..sheet
        };
        let mut plant = PlantConfig::new(motor, supply);
        plant.angle_deg = angle_deg;
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
}

/// The crest of a step stays within the rating. Commutation takes half of the current and the step makes up
/// for it: the limit is on the mean, and the crest is a third above it. The angle at the start determines the
/// phase of the commutations in the tick, so each preset starts from many angles.
#[test]
fn crest_of_a_step_stays_within_the_rating() {
    let mut starts = Vec::new();
    for preset in &PRESETS {
        let angles = (0..16).map(|k| 22.5 * f64::from(k));
        for (supply, angle) in
            [36.0, 48.0, 60.0].iter().flat_map(|supply| angles.clone().map(|angle| (*supply, angle)))
        {
            for mode in [Mode::Hall, Mode::Sensorless] {
                for off_the_sheet in [false, true] {
                    starts.push(Start { preset, supply, mode, angle_deg: angle, off_the_sheet });
                }
            }
        }
    }
    let peaks = map(&starts, |start| start.peak());
    let mut beyond = Vec::new();
    let mut highest = [0.0_f64; 2];
    for (start, peak) in starts.iter().zip(peaks) {
        let Start { preset, supply, mode, angle_deg, off_the_sheet } = *start;
        let highest = &mut highest[usize::from(off_the_sheet)];
        *highest = highest.max(peak);
        if peak > if off_the_sheet { PEAK_OFF_THE_SHEET } else { PEAK } {
            beyond.push(format!(
                "{} at {supply} V, {}, from {angle_deg} degrees: {peak:.2} A",
                preset.name,
                mode.name()
            ));
        }
    }
    println!("phase current up to {:.2} A as on the data sheet, {:.2} A off it", highest[0], highest[1]);
    assert_eq!(beyond, Vec::<String>::new());
    // Without reaching the limit this would show nothing.
    assert!(highest[0] > 11.0, "{:.2} A", highest[0]);
}
