//! Tests of the firmware image.

use crate::board;
use crate::firmware;
use crate::image::EMBEDDED;
use crate::image::Image;
use crate::replayer::{ARGUMENTS, Replayer};
use crate::test::python;
use crate::{examples, hangs, instructions, others, proof, qemu, slots, small};
use narx_report::steps::{self, Outcome, Step};
use std::env;
use std::path::Path;
use std::process::Command;

/// Lints of the images themselves: on this machine they are empty.
const LINTS: [&str; 10] =
    ["clippy", "--quiet", "-p", "narx-firmware", "--bins", "--target", EMBEDDED, "--", "-D", "warnings"];

/// Lints of the board on silicon.
const BOARD_LINTS: [&str; 12] = [
    "clippy",
    "--quiet",
    "-p",
    board::PACKAGE,
    "--bins",
    "--features",
    "test-key",
    "--target",
    EMBEDDED,
    "--",
    "-D",
    "warnings",
];

/// Steps in their order.
pub(crate) fn steps(root: &Path) -> Vec<Step<'_>> {
    vec![
        Step::command(
            root,
            "shell",
            "cargo",
            &["test", "--profile", "front", "-p", "narx-board", "--features", "update"],
        ),
        Step::new("emulator", firmware::emulator),
        Step::new("images", move || firmware::build(root).and_then(|_| firmware::sizes(root))),
        Step::command(root, "image lints", "cargo", &LINTS),
        Step::new("fewer modes", move || fewer_modes(root)),
        Step::new("small board", move || small::regenerate(root, true)),
        Step::command(
            root,
            "board, pure parts",
            "cargo",
            &["test", "--profile", "front", "-p", board::PACKAGE],
        ),
        Step::new("board", move || board::build(root).and_then(|_| board::regenerate(root, true))),
        Step::command(root, "board lints", "cargo", &BOARD_LINTS),
        Step::new("examples", move || examples::regenerate(root, true)),
        Step::new("instructions", move || instructions::regenerate(root, true)),
        Step::new("other crates", move || others::check(root)),
        Step::new("proof", move || proof::regenerate(root, true)),
        Step::new("watchdog", move || hangs::run(root)),
        Step::new("slots", move || slots::make(root)),
        Step::new("virtual drive", move || drive(root)),
        Step::new("boards on their chips' model", move || chip(root)),
    ]
}

/// Builds of the core that leave out control modes: their commands are the full build's.
fn fewer_modes(root: &Path) -> Outcome {
    let mut closing = Vec::new();
    for modes in ["hall", "sensorless"] {
        let mut cargo = Command::new("cargo");
        cargo.args(["test", "--profile", "front", "-p", "narx-small", "--test", "modes"]);
        cargo.args(["--no-default-features", "--features", modes]);
        closing.extend(steps::run(cargo.current_dir(root))?);
    }
    Ok(closing)
}

/// Programs that replay recordings, once [`steps`] has built them.
pub(crate) fn replayers(root: &Path) -> Vec<Replayer> {
    vec![Replayer::new("Rust Cortex-M4F", &qemu::semihosting(&Image::Replay.path(root), &[ARGUMENTS]))]
}

/// Runs the images of boards on a model of their chips, against the simulated motor.
fn chip(root: &Path) -> Outcome {
    let python = python::prepare(root)?;
    slots::make_for_board(root)?;
    let mut tests = Command::new(python);
    if env::var_os("NARX_LONG").is_some_and(|long| long == "1") {
        tests.env("NARX_BOARD_IMAGE_20_KHZ", board::build_at_20_khz(root)?);
    }
    steps::run(
        tests
            // The board's time is the model's own, so the tests of several files run at once.
            .args([
                "-m",
                "pytest",
                "--color=no",
                "-p",
                "no:cacheprovider",
                "-n",
                "auto",
                "--dist",
                "loadfile",
            ])
            .arg(root.join("tests/chip"))
            .env("NARX_BOARD_IMAGE", board::path(root, "drive"))
            .env("NARX_BOARD_BOOTLOADER", board::path(root, "boot"))
            .env("NARX_BOARD_SLOTS", slots::directory_of_board(root))
            .env("NARX_EXAMPLES", examples::directory(root))
            .env("PYTHONDONTWRITEBYTECODE", "1"),
    )
}

/// Spins the motor of the real image through python-can.
fn drive(root: &Path) -> Outcome {
    let tests = root.join("tests/firmware");
    // Some of the tests operate it by our own package.
    let python = python::prepare(root)?;
    // The tests choose the port, and start and end the emulator themselves.
    let emulator = qemu::with_serial_port(&Image::Drive.path(root), &[] as &[&str], "{port}");
    let words = |command: &Command| -> Vec<String> {
        let words = [command.get_program()].into_iter().chain(command.get_args());
        words.map(|word| word.to_string_lossy().into_owned()).collect()
    };
    let bootloader = qemu::with_kept_flash(&Image::Bootloader.path(root), "{port}", "{flash}");
    steps::run(
        Command::new(python)
            .args(["-m", "pytest", "--color=no", "-p", "no:cacheprovider"])
            .arg(&tests)
            .env("NARX_QEMU", words(&emulator).join("\n"))
            .env("NARX_QEMU_BOOTLOADER", words(&bootloader).join("\n"))
            .env("NARX_QEMU_SLOTS", slots::directory(root))
            .env("PYTHONDONTWRITEBYTECODE", "1"),
    )
}
