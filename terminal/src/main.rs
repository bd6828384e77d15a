//! Programs for a terminal: `demo`, `drive` and `sign`, which are commands of `cargo xtask`, too.

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use narx_terminal::{demo, drive, sign};
use std::process::ExitCode;

#[derive(Parser)]
#[command(
    name = "narx-terminal",
    about = "A motor on a simulated bench, and images for its bootloader",
    version
)]
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
    /// Sign a program for the bootloader, or make a key
    Sign(sign::Arguments),
}

fn main() -> ExitCode {
    // Cargo sets this variable for what it runs.
    let called = if std::env::var_os("CARGO").is_some() { "cargo xtask" } else { "narx-terminal" };
    let matches = Arguments::command().bin_name(called).get_matches();
    match Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit()).job {
        Job::Demo(arguments) => demo::run(&arguments),
        Job::Drive(arguments) => drive::run(&arguments),
        Job::Sign(arguments) => sign::command(&arguments),
    }
}
