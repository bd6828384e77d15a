//! Developer commands of narx: `cargo xtask help` lists them.
//!
//! This program installs tools and runs them. It builds in seconds and knows nothing of motors: experiments
//! on the bench are narx-lab's, generated documents narx-generate's, and the programs for a terminal
//! narx-terminal's; their commands are handed over.

mod archive;
mod audit;
mod bench;
mod board;
mod branches;
mod callgrind;
mod conformance;
mod cross;
mod driven;
mod examples;
mod files;
mod firmware;
mod floor;
mod fuzz;
mod hangs;
mod image;
mod install;
mod instructions;
mod interop;
mod library;
mod mutants;
mod others;
mod programs;
mod proof;
mod qemu;
mod release;
mod replayer;
mod site;
mod sizes;
mod slots;
mod small;
mod test;
mod vectors;
mod web;

use clap::{Parser, Subcommand};
use narx_report::steps::{Outcome, Step, finish, run, run_all};
use programs::{GENERATE, LAB, LAB_RELEASE, Program, TERMINAL};
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, ExitCode};
use test::Target;

#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", about = "Developer commands of narx", version)]
struct Arguments {
    #[command(subcommand)]
    job: Job,
}

/// Arguments of a command that another program carries out: `--help` is answered there, too.
#[derive(clap::Args)]
struct Other {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

#[derive(clap::Args)]
struct Check {
    /// Write nothing; fail if a figure or a file differs
    #[arg(long)]
    check: bool,
}

#[derive(Subcommand)]
enum Job {
    /// Run the demonstration: a motor starts, reaches its speed and holds it
    #[command(disable_help_flag = true)]
    Demo(Other),
    /// Run a virtual drive in real time, with its CAN bus as slcan for python-can and similar tools
    #[command(disable_help_flag = true)]
    Drive(Other),
    /// Sign a program for the bootloader, or make a key
    #[command(disable_help_flag = true)]
    Sign(Other),
    /// Test everything, or one target; installs what that needs
    Test {
        /// Target to test; without a name everything
        target: Option<Target>,
    },
    /// Measure what narx promises and what it costs: one table, each figure with its goal and the command
    /// that measures it again; written to target/bench.json
    Bench(bench::Arguments),
    /// Measure control quality: the promises on every preset and on random motors, as percentiles; writes
    /// docs/evidence/quality.json
    #[command(disable_help_flag = true)]
    Quality(Other),
    /// Measure where the sensorless start succeeds and where it fails; writes docs/evidence/starts.json and
    /// certificate.svg
    #[command(disable_help_flag = true)]
    Certificate(Other),
    /// Identify every motor of the market and random motors on the bench, and compare with the truth
    #[command(disable_help_flag = true)]
    Identify(Other),
    /// Simulate many simultaneous faults, and check what may never happen; `--hours 100 --out docs/evidence`
    /// writes docs/evidence/worlds.json
    #[command(disable_help_flag = true)]
    Worlds(Other),
    /// Make the recordings of the conformance vectors in tests/vectors anew
    #[command(disable_help_flag = true)]
    Vectors(Other),
    /// Replay arbitrary recordings on every target that `test` has built, and compare every digest; `--out
    /// docs/evidence` writes docs/evidence/conformance.json
    #[command(disable_help_flag = true)]
    Conformance(Other),
    /// Make everything anew that is generated and committed: vectors, documents, snapshots, inputs of the
    /// fuzzers, type declarations, golden figures
    Generate,
    /// Make tests/coverage.md anew: each row of the specification, its code and its tests
    #[command(disable_help_flag = true)]
    Coverage(Other),
    /// Make docs/narx.dbc anew: every message and signal as a CAN database
    #[command(disable_help_flag = true)]
    Dbc(Other),
    /// Make docs/eddycan-*.eds anew: the TX-Driver for CANopen tools
    #[command(disable_help_flag = true)]
    Eds(Other),
    /// Make ffi/include/narx*.h anew: the C headers
    #[command(disable_help_flag = true)]
    Header(Other),
    /// Make docs/EVIDENCE.md anew from the figures in docs/evidence
    #[command(disable_help_flag = true)]
    Evidence(Other),
    /// Disable the effect of each row of the specification, and check that its tests fail; writes
    /// tests/effects.toml
    #[command(disable_help_flag = true)]
    Effects(Other),
    /// Make tests/golden/instructions.toml anew: instructions of every control tick on a Cortex-M4F
    Instructions(Check),
    /// Make tests/golden/callgrind.toml anew: instructions of a simulated tick on this machine
    Callgrind(Check),
    /// Prove what no linked program may contain (panics, floating point, unsafe), and the depth of its stack;
    /// makes tests/golden/proof.toml anew
    Proof(Check),
    /// Make tests/golden/ffi_sizes.toml and small_board.toml anew: flash, RAM and instructions of the C
    /// library, whole and by parts; flash of the core on a small board
    Sizes(Check),
    /// Build a firmware image, and run it where there is an emulator for its board
    Firmware(firmware::Arguments),
    /// Build, test and measure the examples for boards; makes tests/golden/examples.toml anew
    Examples(Check),
    /// Build the WebAssembly packages and the page, into wasm/pkg and wasm/web/dist
    Web(web::Arguments),
    /// Build the C library for every target, and pack it with header, CMake package and examples
    Archive,
    /// Make every artefact of a release in one folder; make it again and compare; use each as its user does
    Release(release::Arguments),
    /// Build the reference of the Python package from its docstrings, into target/docs/python
    Docs,
    /// Build the documentation site: guide, references, notebooks and page in one folder, target/site
    Site(site::Arguments),
    /// Test our files and the virtual drive with other people's tools: a part of `test rust`
    Interop,
    /// Check licences, sources and bans of every crate, with cargo-deny
    Audit,
    /// Measure which branches of the core the Rust tests take, with llvm-cov; writes
    /// docs/evidence/branches.json
    Branches(branches::Arguments),
    /// Search for inputs that break a promise, with libFuzzer; or give both nodes every identifier
    Fuzz(fuzz::Arguments),
    /// Change the code one place at a time and check that a test fails, with cargo-mutants; `--out
    /// docs/evidence` writes mutants.json there
    Mutants(mutants::Arguments),
}

fn main() -> ExitCode {
    let root = narx_report::root();
    let other = |program: Program, name: &str, Other { arguments }: Other| {
        program.hand_over(root, &[vec![name.into()], arguments].concat())
    };
    match Arguments::parse().job {
        Job::Demo(arguments) => other(TERMINAL, "demo", arguments),
        Job::Drive(arguments) => other(TERMINAL, "drive", arguments),
        Job::Sign(arguments) => other(TERMINAL, "sign", arguments),
        Job::Test { target } => test::run(root, target),
        Job::Bench(arguments) => finish(bench::run(root, &arguments)),
        Job::Quality(arguments) => other(LAB_RELEASE, "quality", arguments),
        Job::Certificate(arguments) => other(LAB_RELEASE, "certificate", arguments),
        Job::Identify(arguments) => other(LAB_RELEASE, "identify", arguments),
        Job::Worlds(arguments) => other(LAB_RELEASE, "worlds", arguments),
        Job::Vectors(arguments) => other(LAB, "vectors", arguments),
        Job::Conformance(Other { arguments }) => finish(test::conformance(root, &arguments)),
        Job::Generate => generate(root),
        Job::Coverage(arguments) => other(GENERATE, "coverage", arguments),
        Job::Dbc(arguments) => other(GENERATE, "dbc", arguments),
        Job::Eds(arguments) => other(GENERATE, "eds", arguments),
        Job::Header(arguments) => other(GENERATE, "header", arguments),
        Job::Evidence(arguments) => other(GENERATE, "evidence", arguments),
        Job::Effects(arguments) => other(GENERATE, "effects", arguments),
        Job::Instructions(Check { check }) => finish(instructions::command(root, check)),
        Job::Callgrind(Check { check }) => callgrind::command(root, check),
        Job::Proof(Check { check }) => proof::command(root, check),
        Job::Sizes(Check { check }) => run_all(vec![
            Step::new("small board", move || small::regenerate(root, check)),
            Step::new("C sizes", move || sizes::generate(root, check)),
        ]),
        Job::Firmware(arguments) => firmware::command(root, &arguments),
        Job::Examples(Check { check }) => examples::command(root, check),
        Job::Web(arguments) => web::command(root, arguments),
        Job::Archive => archive::command(root),
        Job::Release(arguments) => release::command(root, &arguments),
        Job::Docs => run_all(test::python::docs(root)),
        Job::Site(arguments) => site::command(root, &arguments),
        Job::Interop => finish(interop::run(root)),
        Job::Audit => audit::command(root),
        Job::Branches(arguments) => branches::command(root, &arguments),
        Job::Fuzz(arguments) => fuzz::command(root, arguments),
        Job::Mutants(arguments) => mutants::command(root, &arguments),
    }
}

/// Runs tests of a package in the mode in which they write what they otherwise compare.
fn update(root: &Path, tests: &[&str]) -> Outcome {
    let mut cargo = Command::new("cargo");
    run(cargo
        .args(["test", "-p"])
        .args(tests)
        .current_dir(root)
        .env("UPDATE", "1")
        .env("INSTA_UPDATE", "always"))
}

/// Writes anew every file that the tests compare. `git diff` shows the changes, which must be reviewed.
fn generate(root: &Path) -> ExitCode {
    run_all(vec![
        Step::new("vectors", move || LAB.run(root, &["vectors"])),
        // With this environment the tests write documents, snapshots and the fuzzers' first inputs instead
        // of comparing them.
        Step::new("snapshots", move || {
            update(root, &["narx-tests", "--test", "protocol", "--test", "eddycan"])
        }),
        Step::new("commands", move || {
            update(root, &["narx-small", "--features", "hall-calibration", "--test", "modes"])
        }),
        Step::new("tables of running", move || {
            update(root, &["narx-tests", "--test", "motor", "presets_with"])
        }),
        Step::new("corpus", move || update(root, &["narx-fuzz", "--test", "seeds"])),
        Step::new("documents", move || GENERATE.run(root, &["documents"])),
        Step::new("images", move || firmware::build(root).and_then(|_| firmware::emulator())),
        Step::new("examples", move || examples::regenerate(root, false)),
        Step::new("instructions", move || instructions::regenerate(root, false)),
        Step::new("proof", move || proof::regenerate(root, false)),
        Step::new("callgrind", move || callgrind::regenerate(root, false)),
        Step::new("small board", move || small::regenerate(root, false)),
        Step::new("C sizes", move || sizes::generate(root, false)),
        Step::new("wasm", move || web::generate(root)),
    ])
}
