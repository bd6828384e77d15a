//! The floor to which the control tick is compared: a bare six-step tick by hand in C (`lab/floor/tick.c`),
//! counted on the emulated Cortex-M4F. That it drives a motor is shown by `lab/src/floor.rs`.

use crate::{cross, install, qemu};
use narx_report::steps;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Number of ticks that are counted: 2 s.
const TICKS: u32 = 20_000;

/// Version of the compiler; the figures hold for this version only.
///
/// # Errors
/// Fails if the compiler is missing and cannot be installed.
pub(crate) fn compiler_version() -> Result<String, String> {
    install::debian(&cross::PACKAGES)?;
    let version =
        steps::output(Command::new(cross::Processor::CortexM4F.tool("gcc")).arg("-dumpfullversion"))?;
    Ok(version.trim().to_owned())
}

/// Runs both ticks of a motor that turns at `millihertz`, electrical. Returns a line `floor NAME TICKS TOTAL
/// WORST` for each, and one after `#` that describes its work.
///
/// # Errors
/// Fails with the message of compiler or emulator, or with the tick that does not do its work.
pub(crate) fn run(root: &Path, millihertz: u32) -> Result<String, String> {
    let program = compile(root)?;
    let arguments = [millihertz.to_string(), TICKS.to_string()];
    let mut command = qemu::counting(&program, &arguments);
    let output = command.output().map_err(|error| format!("{}: {error}", qemu::PROGRAM))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(text)
    } else {
        Err(format!("lab/floor/tick.c: {}\n{text}", output.status))
    }
}

fn compile(root: &Path) -> Result<PathBuf, String> {
    let program = narx_report::target_directory(root).join("tick");
    let mut compiler = cross::compiler(root);
    compiler.args(["-std=c99", "-O3"]).args(cross::STRICT).arg(root.join("lab/floor/tick.c"));
    steps::output(compiler.arg("-o").arg(&program)).map(|_| program)
}
