//! Images of the firmware: built, measured, and run in the emulator.

use crate::board;
use crate::image::{EMBEDDED, Image, size};
use crate::install;
use crate::qemu;
use crate::slots;
use clap::ValueEnum;
use narx_report::steps::{self, Outcome};
use std::path::Path;
use std::process::{Command, ExitCode};

/// Arguments of `firmware`.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Board of the image
    #[arg(long)]
    board: Board,
    /// Run the virtual drive; its CAN bus is slcan on a TCP port of this machine
    #[arg(long)]
    run: bool,
    /// TCP port of the virtual drive
    #[arg(long, default_value_t = 2000, requires = "run")]
    port: u16,
    /// Motor on the board, by the name of its preset
    #[arg(long, requires = "run")]
    motor: Option<String>,
    /// Supply voltage of the motor, V
    #[arg(long, requires = "run")]
    supply: Option<u8>,
    /// Write the golden figures of the board anew
    #[arg(long, conflicts_with = "run")]
    golden: bool,
}

/// Board for which an image is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Board {
    /// The emulated mps2-an386 with a simulated motor and power stage
    Qemu,
    /// ST's B-G431B-ESC1: built and measured
    #[value(name = "b-g431b-esc1")]
    Esc1,
}

/// Builds the images of a board, signs those for its slots, and prints their sizes; with `--run` it runs the
/// virtual drive until it is interrupted.
pub(crate) fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    match (arguments.board, arguments.run, arguments.golden) {
        (Board::Esc1, true, _) => return refuse("--run: nobody emulates this board; --board qemu runs"),
        (Board::Qemu, _, true) => {
            return refuse("--golden: figures of the board qemu are made by cargo xtask instructions");
        }
        (Board::Esc1, false, golden) => return board::command(root, golden),
        (Board::Qemu, ..) => {}
    }
    let built = build(root).and_then(|_| sizes(root)).and_then(|mut lines| {
        lines.extend(slots::make(root)?);
        lines.iter().for_each(|line| println!("{line}"));
        if arguments.run { run(root, arguments) } else { Ok(lines) }
    });
    match built {
        Ok(_) => ExitCode::SUCCESS,
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

fn refuse(reason: &str) -> ExitCode {
    steps::finish(Err(reason.into()))
}

/// Installs the target and builds all images.
///
/// # Errors
/// Fails with the message of rustup or cargo.
pub(crate) fn build(root: &Path) -> Outcome {
    install::rust_target(EMBEDDED)?;
    let arguments = ["build", "--release", "-p", "narx-firmware", "--bins", "--target", EMBEDDED];
    steps::run(Command::new("cargo").args(arguments).current_dir(root))
}

/// Installs the emulator.
///
/// # Errors
/// Fails with the command that installs the emulator.
pub(crate) fn emulator() -> Outcome {
    install::debian(&[qemu::PACKAGE])
}

/// Returns a line for each image: bytes of flash, and of RAM without the stack.
///
/// # Errors
/// Fails if an image is missing or invalid.
pub(crate) fn sizes(root: &Path) -> Outcome {
    let line = |image: Image| {
        let path = image.path(root);
        let size = size(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(format!("{:<7} {:>7} bytes of flash, {:>7} of RAM", image.name(), size.flash, size.ram))
    };
    Image::ALL.into_iter().map(line).collect()
}

fn run(root: &Path, arguments: &Arguments) -> Outcome {
    emulator()?;
    let supply = arguments.supply.map(|supply| supply.to_string());
    let mut options = Vec::new();
    for (option, value) in [("--motor", &arguments.motor), ("--supply", &supply)] {
        if let Some(value) = value {
            options.extend([option, value.as_str()]);
        }
    }
    let port = arguments.port.to_string();
    println!("can.Bus(interface=\"slcan\", channel=\"socket://127.0.0.1:{port}\", bitrate=500000)");
    steps::run(&mut qemu::with_serial_port(&Image::Drive.path(root), &options, &port))
}
