//! Commands of `cargo xtask` that run in a terminal: `demo`, `drive` and `sign`.

use clap::{Parser, Subcommand};
use narx_terminal::{demo, drive, sign};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", version)]
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
    match Arguments::parse().job {
        Job::Demo(arguments) => demo::run(&arguments),
        Job::Drive(arguments) => drive::run(&arguments),
        Job::Sign(arguments) => sign::command(&arguments),
    }
}
