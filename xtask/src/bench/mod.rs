//! What narx promises of its control, measured: the table of goals, each with its figure and its verdict, on the motors of the
//! market and on random plants. Everything has a seed; what fails is printed with the command that runs it again.

mod case;
mod cost;
mod decoding;
mod efficiency;
mod faults;
mod load_step;
mod operating;
mod picture;
mod python;
mod range;
mod report;
mod speed;
mod start;
mod starts;
mod steady;
mod top_speed;
mod trial;

pub use narx_host::parallel::map;
pub use operating::{Figures, Point};
pub use speed::command as speed;
pub use start::{Ending, Start};

use clap::Args;
use report::Row;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Arguments of `bench`.
#[derive(Args, Debug)]
pub struct Arguments {
    /// Random plants to start
    #[arg(long, default_value_t = 10_000)]
    pub runs: u64,
    /// Which series of random plants: their seeds are S x 1 000 000 and on
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Run one random plant again, by its seed, and write its run.svg, run.csv and run.narxrec
    #[arg(long)]
    pub case: Option<u64>,
    /// Where bench.json and starts.svg go
    #[arg(long, default_value = "target/bench")]
    pub out: PathBuf,
}

/// Measures everything; exit code 1 if a promise is not kept.
pub fn command(arguments: &Arguments) -> ExitCode {
    let outcome = match arguments.case {
        Some(seed) => case::replay(seed, &arguments.out),
        None => measure(arguments),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{}: {error}", arguments.out.display());
            ExitCode::FAILURE
        }
    }
}

/// The working copy.
fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// True if every promise is kept.
fn measure(arguments: &Arguments) -> io::Result<bool> {
    fs::create_dir_all(&arguments.out)?;
    let begun = Instant::now();
    let cases = starts::cases(arguments.seed, arguments.runs);
    println!(
        "{} sensorless starts of random plants, seeds {} and on",
        cases.len(),
        arguments.seed * 1_000_000
    );
    let starts: Vec<Start> = map(&cases, |case| Start::run(*case)).into_iter().flatten().collect();
    println!("  {:.0} s", begun.elapsed().as_secs_f64());
    let mut rows: Vec<Row> = starts::rows(&starts, cases.len());
    for (name, part) in [
        ("time to closed loop", starts::nominal as fn(&[u64]) -> Vec<Row>),
        ("steady running", steady::rows),
        ("load steps", load_step::rows),
        ("top speed", top_speed::rows),
        ("speed range", range::rows),
        ("efficiency", efficiency::rows),
        ("faults", faults::rows),
        ("speed of simulation", speed::rows),
        ("logs in Python", decoding::rows),
        ("speed from Python", python::rows),
    ] {
        let begun = Instant::now();
        println!("{name}");
        rows.extend(part(&cases));
        println!("  {:.0} s", begun.elapsed().as_secs_f64());
    }
    println!();
    report::print(&rows);
    println!();
    cost::print(root());
    fs::write(arguments.out.join("bench.json"), report::json(&rows, arguments, cases.len()))?;
    fs::write(arguments.out.join("starts.svg"), picture::svg(&starts).map_err(io::Error::other)?)?;
    println!(
        "written to {}: bench.json starts.svg ({:.0} s)",
        arguments.out.display(),
        begun.elapsed().as_secs_f64()
    );
    Ok(rows.iter().all(|row| row.met))
}
