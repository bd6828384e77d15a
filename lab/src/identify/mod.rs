//! Identification against the truth: every motor of the market and random motors, at any temperature.

mod off_sheet;

use crate::pwm_rate::PwmRate;
use crate::quality::motor::{self, Subject};
use clap::Args;
use narx_core::dictionary::Parameters;
use narx_core::identification::{Asked, Identification, IdentificationError, Identified, Stage};
use narx_core::master::{Config, Master};
use narx_core::motor::Board;
use narx_host::parallel::map;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::plant::{MotorConfig, PlantConfig};
use narx_sim::presets::PRESETS;
use narx_sim::random::Random;
use std::process::ExitCode;

/// Arguments of `identify`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Number of random motors
    #[arg(long, default_value_t = 1_000)]
    pub motors: u64,
    /// Seed of the first one
    #[arg(long, default_value_t = 0)]
    pub first: u64,
    /// Run one random motor again, by its seed
    #[arg(long)]
    pub case: Option<u64>,
    /// Instead, commission motors that are not as their data sheet says: from the truth, from the sheet, and
    /// from what was measured
    #[arg(long, conflicts_with = "case")]
    pub off_sheet: bool,
    #[command(flatten)]
    rate: PwmRate,
}

/// Simulated time after which the drive has booted, s.
const BOOTED: f64 = 1.2;
/// Longest identification, s of simulated time.
const LONGEST: f64 = 60.0;

/// Time within which a motor should be identified, s.
const TIME: f64 = 15.0;
/// Stages that take most of the time.
const STAGES: [Stage; 3] = [Stage::Holds, Stage::Spins, Stage::Accelerates];

/// Share of the rated torque that the friction may be off, where its limit is less.
const OF_RATED_TORQUE: f64 = 1e-3;

/// The measured figures with their limits: the largest error, as a share, that an identification should have.
const FIGURES: [(&str, f64); 5] = [
    ("resistance", 0.03),
    ("inductance", 0.10),
    ("torque constant", 0.02),
    ("inertia", 0.10),
    ("friction", 0.10),
];

/// Measures and prints.
pub fn command(arguments: &Arguments) -> ExitCode {
    arguments.rate.run(|board| {
        if arguments.off_sheet {
            off_sheet::run(board, arguments.motors);
            return Ok(true);
        }
        let seeds: Vec<u64> = match arguments.case {
            Some(seed) => vec![seed],
            None => (arguments.first..arguments.first + arguments.motors).collect(),
        };
        let drawn = map(&seeds, |seed| motor::random(board, *seed).map(|subject| (*seed, subject)));
        let mut subjects: Vec<(u64, Subject)> = Vec::new();
        if arguments.case.is_none() {
            subjects.extend(PRESETS.iter().map(|preset| (0, motor::of_market(board, preset))));
        }
        let of_market = subjects.len();
        subjects.extend(drawn.into_iter().flatten());
        let trials = map(&subjects, |(seed, subject)| Trial::run(board, subject, *seed));
        for trial in &trials {
            println!("{}", trial.line());
        }
        let (presets, random) = trials.split_at(of_market);
        for (name, trials) in [("presets", presets), ("random motors", random)] {
            if !trials.is_empty() {
                summarise(name, trials);
            }
        }
        Ok(true)
    })
}

/// The identification of one motor.
struct Trial {
    name: String,
    motor: MotorConfig,
    /// N m; 0 if it is unknown.
    rated_torque: f64,
    /// `None` if it has not ended in time.
    outcome: Option<Result<Identified, IdentificationError>>,
    /// Temperature of the winding when its resistance was measured, and at the end, degrees Celsius.
    temperatures: [f64; 2],
    /// s.
    time: f64,
    /// Time, s, and largest phase current, A, of each of [`STAGES`].
    stages: [(f64, f64); STAGES.len()],
    /// Largest speed, as a share of the one whose back-EMF is the supply's voltage.
    fastest: f64,
}

/// A measured figure and its stated uncertainty, over the true one.
#[derive(Clone, Copy)]
struct Ratio {
    value: f64,
    uncertainty: f64,
    /// Error that is allowed at least.
    least: f64,
}

impl Ratio {
    fn error(&self) -> f64 {
        (self.value - 1.0).abs()
    }
}

impl Trial {
    /// Runs it on a bench with offsets and a temperature of its own.
    fn run(board: &Board, subject: &Subject, seed: u64) -> Self {
        let motor = subject.preset.motor;
        let mut random = Random::new(seed ^ 0x0001_DE47);
        let mut plant = PlantConfig { board: *board, ..PlantConfig::new(motor, subject.supply) };
        (plant.ambient, plant.seed) = (60.0 * random.uniform(), seed);
        let mut offset = |codes: f64| codes * (2.0 * random.uniform() - 1.0);
        plant.converter.bus_voltage_offset = offset(3.0);
        plant.converter.bus_current_offset = offset(3.0);
        plant.converter.phase_voltage_offset = [offset(2.0), offset(2.0), offset(2.0)];
        let config = BenchConfig { plant, parameters: Parameters::new(), label: String::new(), trace: false };
        let mut bench = Bench::new(&config).without_recording();
        let mut master = Master::new(Config::default());
        let mut identification = Identification::new(Asked::new(motor.pole_pairs)).expect("a pole pair");
        let (mut outcome, mut held) = (None, None);
        let mut stages = [(0.0, 0.0_f64); STAGES.len()];
        let mut fastest = 0.0_f64;
        while outcome.is_none() && bench.time() < BOOTED + LONGEST {
            let now = bench.now_ns() / 1000;
            if bench.time() > BOOTED {
                outcome = identification.step(&mut master, now);
            }
            if held.is_none() && !matches!(identification.stage(), Stage::Asks | Stage::Holds) {
                held = Some(bench.plant().winding_temperature());
            }
            while let Some(frame) = master.poll_frame(now) {
                bench.send(frame).expect("a bus without errors");
            }
            let stage = STAGES.iter().position(|stage| *stage == identification.stage());
            for _ in 0..5 {
                bench.step();
                if let Some((time, peak)) = stage.map(|stage| &mut stages[stage]) {
                    *time += 1.0 / f64::from(board.tick_rate);
                    *peak = peak.max(bench.plant().peak_current());
                }
            }
            fastest = fastest.max(bench.plant().observe().speed.abs());
            while let Some(received) = bench.receive() {
                master.handle_frame(&received.frame, received.time_ns / 1000);
            }
            while bench.monitor().is_some() {}
        }
        let end = bench.plant().winding_temperature();
        Self {
            name: subject
                .command
                .rsplit("--")
                .find(|part| !part.starts_with("pwm-rate"))
                .unwrap_or("")
                .to_owned(),
            motor,
            rated_torque: subject.preset.data.rated_torque.unwrap_or(0.0),
            outcome,
            temperatures: [held.unwrap_or(end), end],
            time: bench.time() - BOOTED,
            stages,
            fastest: fastest * motor.torque_constant / subject.supply,
        }
    }

    /// The measured figures over the true ones, in the order of [`FIGURES`].
    fn ratios(&self) -> Option<[Ratio; 5]> {
        let found = self.outcome.as_ref()?.as_ref().ok()?;
        let turned = found.turned?;
        let m = &self.motor;
        let [cold, hot] = self.temperatures.map(|temperature| temperature - 25.0);
        let figures = [
            (found.resistance, m.resistance * (1.0 + m.copper_drift * cold)),
            (found.inductance, m.inductance),
            (turned.torque_constant, m.torque_constant * (1.0 + m.magnet_drift * hot)),
            (turned.inertia, m.inertia),
            (turned.friction, m.static_friction + m.viscous_friction * turned.speed),
        ];
        let mut ratios = figures.map(|(figure, truth)| Ratio {
            value: figure.value / truth,
            uncertainty: figure.uncertainty / truth,
            least: 0.0,
        });
        ratios[4].least = OF_RATED_TORQUE * self.rated_torque / figures[4].1;
        Some(ratios)
    }

    /// Largest phase current, A.
    fn peak(&self) -> f64 {
        self.stages.iter().fold(0.0, |most, (_, peak)| peak.max(most))
    }

    fn line(&self) -> String {
        let result = match (&self.outcome, self.ratios()) {
            (_, Some(ratios)) => {
                ratios.map(|ratio| format!("{:.3} +- {:.3}", ratio.value, ratio.uncertainty)).join("  ")
            }
            (Some(Err(error)), _) => error.to_string(),
            _ => "has not ended".to_owned(),
        };
        format!("{:28} {:5.1} s  {:4.1} A  {result}", self.name, self.time, self.peak())
    }
}

fn summarise(name: &str, trials: &[Trial]) {
    let measured: Vec<[Ratio; 5]> = trials.iter().filter_map(Trial::ratios).collect();
    println!("{name}: {} of {} identified", measured.len(), trials.len());
    for (place, (figure, limit)) in FIGURES.into_iter().enumerate() {
        let ratios: Vec<Ratio> = measured.iter().map(|ratios| ratios[place]).collect();
        let per_cent = |holds: &dyn Fn(&Ratio) -> bool| {
            100.0 * ratios.iter().filter(|ratio| holds(ratio)).count() as f64 / ratios.len().max(1) as f64
        };
        let mut sorted: Vec<f64> = ratios.iter().map(Ratio::error).collect();
        println!(
            "{figure:16} within {limit}: {:.1} %; within what was stated: {:.1} %; {}",
            per_cent(&|ratio| ratio.error() <= limit.max(ratio.least)),
            per_cent(&|ratio| ratio.error() <= ratio.uncertainty),
            spread(&mut sorted, "")
        );
    }
    let over = |of: &dyn Fn(&Trial) -> f64, unit: &str| {
        spread(&mut trials.iter().map(of).collect::<Vec<f64>>(), unit)
    };
    let ended = trials.iter().filter(|trial| trial.ratios().is_some());
    let soon = ended.filter(|trial| trial.time <= TIME).count();
    println!(
        "time: {}; of the identified within {TIME} s: {:.1} %",
        over(&|trial| trial.time, " s"),
        100.0 * soon as f64 / measured.len().max(1) as f64
    );
    for (place, stage) in STAGES.iter().enumerate() {
        println!("{}: {}", stage.name(), over(&|trial| trial.stages[place].0, " s"));
        println!("  peak current: {}", over(&|trial| trial.stages[place].1, " A"));
    }
    println!("peak current: {}", over(&Trial::peak, " A"));
    println!(
        "largest speed, as a share of supply over back-EMF constant: {}",
        over(&|trial| trial.fastest, "")
    );
}

/// Median, 95th percentile and maximum.
fn spread(values: &mut [f64], unit: &str) -> String {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((values.len().saturating_sub(1) as f64 * share) as usize);
    let [half, most, all] =
        [0.5, 0.95, 1.0].map(|share| at(share).map_or("-".to_owned(), |value| format!("{value:.3}{unit}")));
    format!("median {half}, 95 % {most}, worst {all}")
}
