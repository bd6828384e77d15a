//! Identification against the truth: every motor of the market and random motors, at any temperature.

use crate::pwm_rate::PwmRate;
use crate::quality::motor::{self, Subject};
use clap::Args;
use narx_core::identification::{Asked, Identification, IdentificationError, Identified, Stage, Turned};
use narx_core::master::{Config, Master};
use narx_core::motor::Board;
use narx_host::parallel::map;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::plant::PlantConfig;
use narx_sim::presets::PRESETS;
use narx_sim::random::Random;
use std::path::Path;
use std::process::ExitCode;

/// Arguments of `identify`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Number of random motors
    #[arg(long, default_value_t = 1_000)]
    pub motors: u64,
    /// Run one random motor, by its seed
    #[arg(long)]
    pub case: Option<u64>,
    #[command(flatten)]
    rate: PwmRate,
}

/// Longest identification, s of simulated time.
const LONGEST: f64 = 60.0;

/// Measures and prints.
pub fn command(_root: &Path, arguments: &Arguments) -> ExitCode {
    arguments.rate.run(|board| {
        let subjects: Vec<Subject> = match arguments.case {
            Some(seed) => motor::random(board, seed).into_iter().collect(),
            None => {
                let seeds: Vec<u64> = (0..arguments.motors).collect();
                let of_market = PRESETS.iter().map(|preset| motor::of_market(board, preset));
                of_market
                    .chain(map(&seeds, |seed| motor::random(board, *seed)).into_iter().flatten())
                    .collect()
            }
        };
        let places: Vec<usize> = (0..subjects.len()).collect();
        let tried = map(&places, |place| identify(board, &subjects[*place], *place as u64));
        for trial in &tried {
            println!("{}", trial.line());
        }
        summary(&tried);
        Ok(true)
    })
}

struct Trial {
    name: String,
    outcome: Result<Identified, IdentificationError>,
    truth: Truth,
    time: f64,
    hottest: f64,
    peak: f64,
}

/// The motor at the temperature that it had.
struct Truth {
    resistance: f64,
    inductance: f64,
    torque_constant: f64,
    inertia: f64,
    rated_torque: f64,
    friction: Box<dyn Fn(f64) -> f64 + Send>,
}

fn identify(board: &Board, subject: &Subject, seed: u64) -> Trial {
    let mut random = Random::new(seed ^ 0x0001_DE47);
    let config = subject.preset.motor;
    let ambient = 0.0 + 60.0 * random.uniform();
    let mut plant = PlantConfig { board: *board, ..PlantConfig::new(config, subject.supply) };
    plant.ambient = ambient;
    plant.seed = seed;
    let mut offset = |span: f64| span * (2.0 * random.uniform() - 1.0);
    plant.converter.bus_voltage_offset = offset(3.0);
    plant.converter.bus_current_offset = offset(3.0);
    plant.converter.phase_voltage_offset = [offset(2.0), offset(2.0), offset(2.0)];
    let bench = Bench::new(&BenchConfig {
        plant,
        parameters: narx_core::dictionary::Parameters::new(),
        label: String::new(),
        trace: false,
    });
    let mut bench = bench.without_recording();
    let mut master = Master::new(Config::default());
    let mut identification = Identification::new(Asked::new(config.pole_pairs)).expect("a pole pair or more");
    let (mut outcome, mut peak, mut held) = (None, 0.0_f64, None);
    let begin = 1.2;
    while outcome.is_none() && bench.time() < LONGEST {
        let now = bench.now_ns() / 1000;
        if bench.time() > begin {
            outcome = identification.step(&mut master, now);
            if held.is_none()
                && identification.stage() != Stage::Asks
                && identification.stage() != Stage::Holds
            {
                held = Some(bench.plant().winding_temperature());
            }
        }
        while let Some(frame) = master.poll_frame(now) {
            bench.send(frame).expect("a bus without errors");
        }
        for _ in 0..5 {
            bench.step();
            peak = peak.max(bench.plant().peak_current());
        }
        while let Some(received) = bench.receive() {
            master.handle_frame(&received.frame, received.time_ns / 1000);
        }
        while bench.monitor().is_some() {}
    }
    let hot = bench.plant().winding_temperature();
    let truth = Truth {
        resistance: config.resistance * (1.0 + config.copper_drift * (held.unwrap_or(hot) - 25.0)),
        inductance: config.inductance,
        torque_constant: config.torque_constant * (1.0 + config.magnet_drift * (hot - 25.0)),
        inertia: config.inertia,
        rated_torque: subject.preset.data.rated_torque.unwrap_or(f64::NAN),
        friction: Box::new(move |speed| config.static_friction + config.viscous_friction * speed),
    };
    Trial {
        name: subject.command.rsplit("--").next().unwrap_or("").to_owned(),
        outcome: outcome.unwrap_or(Err(IdentificationError::Aborted)),
        truth,
        time: bench.time() - begin,
        hottest: hot,
        peak,
    }
}

impl Trial {
    /// Ratios of the measured figures to the truth, with their stated uncertainties.
    fn ratios(&self) -> Option<[(f64, f64); 5]> {
        let found = self.outcome.as_ref().ok()?;
        let Turned { torque_constant, inertia, friction, speed, .. } = found.turned?;
        let truth = &self.truth;
        let figures = [
            (found.resistance, truth.resistance),
            (found.inductance, truth.inductance),
            (torque_constant, truth.torque_constant),
            (inertia, truth.inertia),
            (friction, (truth.friction)(speed)),
        ];
        Some(figures.map(|(figure, truth)| (figure.value / truth, figure.uncertainty / truth)))
    }

    fn line(&self) -> String {
        match (&self.outcome, self.ratios()) {
            (Err(error), _) => format!("{:28} {:5.1} s {error}", self.name, self.time),
            (_, Some(ratios)) => {
                let texts = ratios.map(|(ratio, uncertainty)| format!("{ratio:.3}~{uncertainty:.3}"));
                format!(
                    "{:28} {:5.1} s {} {:.1} C {:.1} A",
                    self.name,
                    self.time,
                    texts.join(" "),
                    self.hottest,
                    self.peak
                )
            }
            _ => self.name.clone(),
        }
    }
}

fn summary(tried: &[Trial]) {
    let names = ["resistance", "inductance", "torque constant", "inertia", "friction"];
    let limits = [0.03, 0.10, 0.02, 0.10, 0.10];
    let measured: Vec<[(f64, f64); 5]> = tried.iter().filter_map(Trial::ratios).collect();
    println!("{} of {} identified", measured.len(), tried.len());
    for (place, name) in names.into_iter().enumerate() {
        let mut off: Vec<f64> = measured.iter().map(|ratios| (ratios[place].0 - 1.0).abs()).collect();
        off.sort_by(f64::total_cmp);
        let at = |share: f64| {
            off.get(((off.len() as f64 * share) as usize).min(off.len().saturating_sub(1)))
                .copied()
                .unwrap_or(f64::NAN)
        };
        let within = off.iter().filter(|off| **off <= limits[place]).count();
        let covered =
            measured.iter().filter(|ratios| (ratios[place].0 - 1.0).abs() <= ratios[place].1).count();
        let share = |count: usize| 100.0 * count as f64 / measured.len().max(1) as f64;
        println!(
            "{name:16} median {:.3} 95 % {:.3} worst {:.3}; within {}: {:.1} %; truth within what was stated: {:.1} %",
            at(0.5),
            at(0.95),
            at(1.0),
            limits[place],
            share(within),
            share(covered)
        );
    }
    let mut times: Vec<f64> = tried.iter().map(|trial| trial.time).collect();
    times.sort_by(f64::total_cmp);
    println!("time: median {:.1} s, longest {:.1} s", times[times.len() / 2], times[times.len() - 1]);
    let _ = tried.iter().map(|trial| trial.truth.rated_torque).sum::<f64>();
}
