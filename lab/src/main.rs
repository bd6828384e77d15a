//! Commands of `cargo xtask` that experiment on the bench.

use clap::{Parser, Subcommand};
use narx_lab::{certificate, conformance, identify, promises, quality, running, vectors, worlds};
use narx_report::root;
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Arguments {
    #[command(subcommand)]
    job: Job,
}

#[derive(Subcommand)]
enum Job {
    /// Measure the promises on the bench: a part of `bench`
    Promises(promises::Arguments),
    /// Measure control quality: the promises on every preset and on random motors, as percentiles; writes
    /// docs/evidence/quality.json
    Quality(quality::Arguments),
    /// Simulate many simultaneous faults, and check what may never happen; `--hours 100 --out docs/evidence`
    /// writes docs/evidence/worlds.json
    Worlds(worlds::Arguments),
    /// Measure where the sensorless start succeeds and where it fails; writes docs/evidence/starts.json and
    /// certificate.svg
    Certificate(certificate::Arguments),
    /// Identify every motor of the market and random motors on the bench, and compare with the truth
    Identify(identify::Arguments),
    /// Replay vectors or arbitrary recordings on the given targets, and compare every digest; `--out
    /// docs/evidence` writes docs/evidence/conformance.json
    Conformance(conformance::Arguments),
    /// Make the recordings of the conformance vectors in tests/vectors anew
    Vectors {
        /// Write nothing; fail if a recording differs from the one that its scenario gives
        #[arg(long)]
        check: bool,
    },
    /// Record the demonstration's motor in steady running, with and without sensors, for counting; prints a
    /// line for each
    Running {
        /// Folder for the recordings
        out: PathBuf,
    },
}

fn main() -> ExitCode {
    let root = root();
    match Arguments::parse().job {
        Job::Promises(arguments) => promises::command(root, &arguments),
        Job::Quality(arguments) => quality::command(root, &arguments),
        Job::Worlds(arguments) => worlds::command(root, &arguments),
        Job::Certificate(arguments) => certificate::command(root, &arguments),
        Job::Identify(arguments) => identify::command(&arguments),
        Job::Conformance(arguments) => conformance::command(root, &arguments),
        Job::Vectors { check } => vectors::command(root, check),
        Job::Running { out } => running::command(&out),
    }
}
