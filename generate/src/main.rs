//! Commands of `cargo xtask` that make the committed files.

use clap::{Args, Parser, Subcommand};
use narx_generate::{
    Make, coefficients, coverage, dbc, eds, effects, evidence, header, pictures, port, samples, settings,
    settle,
};
use narx_report::root;
use narx_report::steps::{Step, finish, run_all};
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
struct Arguments {
    #[command(subcommand)]
    job: Job,
}

#[derive(Args)]
struct Check {
    /// Write nothing; fail if a file differs
    #[arg(long)]
    check: bool,
}

#[derive(Subcommand)]
enum Job {
    /// Make every document anew
    Documents(Check),
    /// Make tests/coverage.md anew: each row of the specification, its code and its tests
    Coverage(Check),
    /// Make docs/narx.dbc anew: every message and signal as a CAN database
    Dbc(Check),
    /// Make docs/eddycan-*.eds anew: the TX-Driver for CANopen tools
    Eds(Check),
    /// Make ffi/include/narx.h and ffi/src/blocks/settings.rs anew: the C header, and the settings in it
    Header(Check),
    /// Make docs/EVIDENCE.md anew from the figures in docs/evidence
    Evidence(Check),
    /// Disable the effect of each row of the specification, and check that its tests fail; writes
    /// tests/effects.toml
    Effects(effects::Arguments),
    /// Make docs/run-*.svg anew: the picture of the README
    Pictures(Check),
    /// Write samples for other people's tools: a part of `interop`
    Samples {
        /// Folder for the samples
        out: PathBuf,
    },
}

/// Documents in their order.
const DOCUMENTS: [(&str, Make); 9] = [
    ("coverage", coverage::make),
    ("CAN database", dbc::make),
    ("EDS", eds::make),
    ("settings of the blocks", settings::make),
    ("C header", header::make),
    ("C coefficients", coefficients::make),
    ("tables for a port", port::make),
    ("pictures", pictures::make),
    ("evidence", evidence::make),
];

fn main() -> ExitCode {
    let root = root();
    let one = |make: Make, Check { check }| finish(settle(root, make, check));
    match Arguments::parse().job {
        Job::Documents(Check { check }) => {
            let step = |(name, make)| Step::new(name, move || settle(root, make, check));
            run_all(DOCUMENTS.map(step).into())
        }
        Job::Coverage(check) => one(coverage::make, check),
        Job::Dbc(check) => one(dbc::make, check),
        Job::Eds(check) => one(eds::make, check),
        Job::Header(Check { check }) => {
            let made = settle(root, settings::make, check).and_then(|_| settle(root, header::make, check));
            finish(made)
        }
        Job::Evidence(check) => one(evidence::make, check),
        Job::Effects(arguments) => effects::command(root, &arguments),
        Job::Pictures(check) => one(pictures::make, check),
        Job::Samples { out } => finish(
            samples::write(&out).map(|()| Vec::new()).map_err(|error| format!("{}: {error}", out.display())),
        ),
    }
}
