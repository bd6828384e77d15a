//! Developer commands of narx: `cargo xtask help` lists them.

use clap::{Parser, Subcommand};
use std::path::Path;
use std::process::{Command, ExitCode};
use xtask::archive;
use xtask::audit;
use xtask::bench;
use xtask::branches;
use xtask::callgrind;
use xtask::certificate;
use xtask::coverage;
use xtask::dbc;
use xtask::demo;
use xtask::drive;
use xtask::eds;
use xtask::effects;
use xtask::evidence;
use xtask::firmware;
use xtask::fuzz;
use xtask::header;
use xtask::instructions;
use xtask::interop;
use xtask::mutants;
use xtask::parity;
use xtask::proof;
use xtask::quality;
use xtask::readme;
use xtask::sign;
use xtask::steps::{Outcome, Step, finish, run, run_all};
use xtask::test::{self, Target};
use xtask::vectors;
use xtask::web;
use xtask::worlds;
use xtask::{sizes, small};

#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", about = "Developer commands of narx", version)]
struct Arguments {
    #[command(subcommand)]
    job: Job,
}

#[derive(Subcommand)]
enum Job {
    /// Run the demonstration: a motor starts, reaches its speed and holds it
    Demo(demo::Arguments),
    /// Run a virtual drive in real time, with its CAN bus as slcan for python-can and similar tools
    Drive(drive::Arguments),
    /// Measure what narx promises and what it costs: one table, each figure with its goal and the command
    /// that measures it again; written to target/bench.json
    Bench(bench::Arguments),
    /// Measure how fast the bench simulates, beside a C loop: a part of `bench`
    Speed {
        /// Measure from Python instead, beside a loop in numba, motulator and gym-electric-motor
        #[arg(long)]
        python: bool,
    },
    /// Measure control quality: the promises on every preset and on random motors, as percentiles; writes
    /// docs/evidence/quality.json
    Quality(quality::Arguments),
    /// Simulate many simultaneous faults, and check what may never happen; `--hours 100 --out docs/evidence`
    /// writes docs/evidence/worlds.json
    Worlds(worlds::Arguments),
    /// Test everything, or one target; installs what that needs
    Test {
        /// Target to test; without a name everything
        target: Option<Target>,
    },
    /// Build the C library for every target, and pack it with header, CMake package and examples
    Archive,
    /// Check licences, sources and bans of every crate, with cargo-deny
    Audit,
    /// Measure which branches of the core the Rust tests take, with llvm-cov; writes
    /// docs/evidence/branches.json
    Branches(branches::Arguments),
    /// Make tests/golden/callgrind.toml anew: instructions of a simulated tick on this machine
    Callgrind {
        /// Write nothing; fail if a figure differs
        #[arg(long)]
        check: bool,
    },
    /// Measure where the sensorless start succeeds and where it fails; writes docs/evidence/starts.json and
    /// certificate.svg
    Certificate(certificate::Arguments),
    /// Replay arbitrary recordings on every target that `test` has built, and compare every digest; writes
    /// docs/evidence/conformance.json
    Conformance(parity::Arguments),
    /// Make tests/coverage.md anew: each row of the specification, its code and its tests
    Coverage {
        /// Write nothing; fail if the page is out of date or names an item that does not exist
        #[arg(long)]
        check: bool,
    },
    /// Make docs/narx.dbc anew: every message and signal as a CAN database
    Dbc {
        /// Write nothing; fail if the database differs from the code
        #[arg(long)]
        check: bool,
    },
    /// Build the reference of the Python package from its docstrings, into target/docs/python
    Docs,
    /// Make docs/eddycan-*.eds anew: the TX-Driver for CANopen tools
    Eds {
        /// Write nothing; fail if a file differs from the code
        #[arg(long)]
        check: bool,
    },
    /// Disable the effect of each row of the specification, and check that its tests fail; writes
    /// tests/effects.toml
    Effects(effects::Arguments),
    /// Make docs/EVIDENCE.md anew from the figures in docs/evidence
    Evidence {
        /// Write nothing; fail if the page differs from the figures
        #[arg(long)]
        check: bool,
    },
    /// Build a firmware image, and run it where there is an emulator for its board
    Firmware(firmware::Arguments),
    /// Make tests/golden/instructions.toml anew: instructions of every control tick on a Cortex-M4F
    Instructions {
        /// Write nothing; fail if a figure differs
        #[arg(long)]
        check: bool,
    },
    /// Search for inputs that break a promise, with libFuzzer; or give both nodes every identifier
    Fuzz(fuzz::Arguments),
    /// Make everything anew that is generated and committed: vectors, coverage, tables of PROTOCOL.md,
    /// snapshots, inputs of the fuzzers, the CAN database, EDS, the C header, type declarations, golden
    /// figures
    Generate,
    /// Make ffi/include/narx.h anew: the C header
    Header {
        /// Write nothing; fail if the header differs from the code
        #[arg(long)]
        check: bool,
    },
    /// Test our files and the virtual drive with other people's tools: a part of `test rust`
    Interop,
    /// Change the code one place at a time and check that a test fails, with cargo-mutants; `--out
    /// docs/evidence` writes mutants.json there
    Mutants(mutants::Arguments),
    /// Sign a program for the bootloader, or make a key
    Sign(sign::Arguments),
    /// Prove what no linked program may contain (panics, floating point, unsafe), and the depth of its stack;
    /// makes tests/golden/proof.toml anew
    Proof {
        /// Write nothing; fail if a figure or a name differs
        #[arg(long)]
        check: bool,
    },
    /// Make tests/golden/ffi_sizes.toml and small_board.toml anew: flash, RAM and instructions of the C
    /// library, whole and by parts; flash of the core on a small board
    Sizes {
        /// Write nothing; fail if a figure differs
        #[arg(long)]
        check: bool,
    },
    /// Make the recordings of the conformance vectors in tests/vectors anew
    Vectors {
        /// Write nothing; fail if a recording differs from the one that its scenario gives
        #[arg(long)]
        check: bool,
    },
    /// Build the WebAssembly packages and the page, into wasm/pkg and wasm/web/dist
    Web(web::Arguments),
}

fn main() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    match Arguments::parse().job {
        Job::Demo(arguments) => demo::run(&arguments),
        Job::Drive(arguments) => drive::run(&arguments),
        Job::Bench(arguments) => bench::command(root, &arguments),
        Job::Quality(arguments) => quality::command(root, &arguments),
        Job::Speed { python } => bench::speed(root, python),
        Job::Worlds(arguments) => worlds::command(root, &arguments),
        Job::Test { target } => test::run(root, target),
        Job::Instructions { check } => instructions::command(root, check),
        Job::Audit => audit::command(root),
        Job::Conformance(arguments) => parity::command(root, &arguments),
        Job::Branches(arguments) => branches::command(root, &arguments),
        Job::Callgrind { check } => callgrind::command(root, check),
        Job::Certificate(arguments) => certificate::command(root, &arguments),
        Job::Coverage { check } => coverage::command(root, check),
        Job::Dbc { check } => dbc::command(root, check),
        Job::Docs => run_all(test::python::docs(root)),
        Job::Eds { check } => eds::command(root, check),
        Job::Effects(arguments) => effects::command(root, &arguments),
        Job::Evidence { check } => evidence::command(root, check),
        Job::Firmware(arguments) => firmware::command(root, &arguments),
        Job::Fuzz(arguments) => fuzz::command(root, arguments),
        Job::Generate => generate(root),
        Job::Header { check } => header::command(root, check),
        Job::Interop => finish(interop::run(root)),
        Job::Mutants(arguments) => mutants::command(root, &arguments),
        Job::Archive => archive::command(root),
        Job::Proof { check } => proof::command(root, check),
        Job::Sign(arguments) => sign::command(&arguments),
        Job::Sizes { check } => run_all(vec![
            Step::new("small board", move || small::regenerate(root, check)),
            Step::new("C sizes", move || sizes::generate(root, check)),
        ]),
        Job::Vectors { check } => vectors::command(root, check),
        Job::Web(arguments) => web::command(root, arguments),
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
        Step::new("vectors", move || vectors::regenerate(root, false)),
        // With this environment the tests write documents, snapshots and the fuzzers' first inputs instead
        // of comparing them.
        Step::new("documents", move || {
            update(root, &["narx-tests", "--test", "protocol", "--test", "eddycan"])
        }),
        Step::new("tables of running", move || {
            update(root, &["narx-tests", "--test", "motor", "presets_with"])
        }),
        Step::new("corpus", move || update(root, &["narx-fuzz", "--test", "seeds"])),
        Step::new("coverage", move || coverage::regenerate(root, false)),
        Step::new("evidence", move || evidence::regenerate(root, false)),
        Step::new("CAN database", move || dbc::regenerate(root, false)),
        Step::new("EDS", move || eds::regenerate(root, false)),
        Step::new("pictures", move || readme::regenerate(root, false)),
        Step::new("C header", move || header::regenerate(root, false)),
        Step::new("images", move || firmware::build(root).and_then(|_| firmware::emulator())),
        Step::new("instructions", move || instructions::regenerate(root, false)),
        Step::new("proof", move || proof::regenerate(root, false)),
        Step::new("callgrind", move || callgrind::regenerate(root, false)),
        Step::new("small board", move || small::regenerate(root, false)),
        Step::new("C sizes", move || sizes::generate(root, false)),
        Step::new("wasm", move || web::generate(root)),
    ])
}
