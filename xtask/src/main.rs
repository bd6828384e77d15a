//! Every developer command of narx: `cargo xtask help` lists them.

use clap::{Parser, Subcommand, ValueEnum};
use std::path::Path;
use std::process::ExitCode;
use xtask::demo;
use xtask::interop;
use xtask::steps::{Step, run_all};

#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", about = "Developer commands of narx", version)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// The main job: a motor starts, reaches its speed and holds it
    Demo(demo::Arguments),
    /// Test everything, or one target; installs what that needs
    Test {
        /// What to test; without a name everything
        target: Option<Target>,
    },
}

/// What can be tested alone.
#[derive(Clone, Copy, ValueEnum)]
enum Target {
    /// Formatting, lints, Rust tests, the build without std, and what other tools make of our files
    Rust,
}

fn main() -> ExitCode {
    match Arguments::parse().command {
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Test { target: None | Some(Target::Rust) } => test_rust(),
    }
}

fn test_rust() -> ExitCode {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."));
    run_all(vec![
        Step::command(root, "format", "cargo", &["fmt", "--all", "--check"]),
        Step::command(
            root,
            "lints",
            "cargo",
            &["clippy", "--workspace", "--all-targets", "--quiet", "--", "-D", "warnings"],
        ),
        Step::command(root, "tests", "cargo", &["test", "--workspace"]),
        // Fails for a package that uses std or the heap: the target has neither.
        Step::command(root, "Cortex-M target", "rustup", &["target", "add", EMBEDDED]),
        Step::command(
            root,
            "no_std",
            "cargo",
            &["build", "-p", "narx-core", "-p", "narx-sim", "--no-default-features", "--target", EMBEDDED],
        ),
        Step::new("interoperability", move || interop::run(root)),
    ])
}

/// A Cortex-M4 with floating point, as on the boards.
const EMBEDDED: &str = "thumbv7em-none-eabihf";
