//! Test of the virtual drive's watchdog: each task hangs on command, in a closed run on the machine's own
//! time.

use crate::image::Image;
use crate::qemu;
use narx_report::steps::Outcome;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Stdio};

/// Tasks that can hang (`firmware/src/boards/qemu/trouble.rs`), with a description.
const TASKS: [(&str, &str); 5] = [
    ("no-control", "the control interrupt does not come"),
    ("control", "the control interrupt does not end"),
    ("can", "sending and receiving hangs"),
    ("background", "reading the slow inputs hangs"),
    ("flash", "serving the flash hangs"),
];
/// Time until the watchdog interrupts; after as much again it resets.
const PERIOD_MS: u32 = 500;
/// Duration of two rounds of the background, in which the watchdog may have been fed once more. They are slow
/// because every instruction takes 128 ns.
const ROUNDS_MS: u32 = 25;

/// Lets every task hang. Returns a line for each with the time of the reset.
///
/// # Errors
/// Fails if there is no reset, a late one, or one for another reason.
pub(crate) fn run(root: &Path) -> Outcome {
    TASKS.iter().map(|(task, what)| hang(root, task, what)).collect()
}

fn hang(root: &Path, task: &str, what: &str) -> Result<String, String> {
    let period = PERIOD_MS.to_string();
    let arguments = ["--watchdog", &period, "--trouble", task, "--after", "300"];
    let mut emulator = Emulator::start(&mut qemu::counting(&Image::Drive.path(root), &arguments))?;
    let line = emulator.line_with("reset: ").ok_or(format!("{task}: no reset"))?;
    let words: Vec<&str> = line.split([' ', ',']).filter(|word| !word.is_empty()).collect();
    let &["reset:", "Watchdog", ms, "ms", ..] = words.as_slice() else {
        return Err(format!("{task}: {line}"));
    };
    let ms: u32 = ms.parse().map_err(|_| format!("{task}: {line}"))?;
    if (PERIOD_MS..=2 * PERIOD_MS + ROUNDS_MS).contains(&ms) {
        Ok(format!("{what}: reset after {ms} ms with a watchdog of 2 x {PERIOD_MS} ms"))
    } else {
        Err(format!("{task}: reset after {ms} ms with a watchdog of 2 x {PERIOD_MS} ms"))
    }
}

/// A run that never ends by itself; killed when dropped.
struct Emulator(Child);

impl Emulator {
    fn start(command: &mut std::process::Command) -> Result<Self, String> {
        let child = command.stdout(Stdio::piped()).spawn();
        child.map(Self).map_err(|error| format!("{}: {error}", qemu::PROGRAM))
    }

    /// Returns the first line that contains `text`.
    fn line_with(&mut self, text: &str) -> Option<String> {
        let output = BufReader::new(self.0.stdout.take()?);
        output.lines().map_while(Result::ok).find(|line| line.contains(text))
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // It may have ended already; then there is nothing to kill.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
