//! The floor beside the control tick: a bare six-step tick by hand in C (`xtask/floor/tick.c`), on the emulated Cortex-M4F.

use crate::{cross, driven, install, qemu};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Ticks that are counted: 2 s.
const TICKS: u32 = 20_000;

/// Version of the compiler, for figures that hold for this one only.
///
/// # Errors
/// It is not there and cannot be installed.
pub fn compiler_version() -> Result<String, String> {
    install::debian(&cross::PACKAGES)?;
    let version = driven::output(Command::new(cross::COMPILER).arg("-dumpfullversion"))?;
    Ok(version.trim().to_owned())
}

/// Runs both ticks of a motor that turns at `millihertz`, electrical: a line `floor NAME TICKS TOTAL WORST` for each, and one behind `#` that
/// says what it did.
///
/// # Errors
/// What compiler or emulator said, or which tick does not do its work.
pub fn run(root: &Path, millihertz: u32) -> Result<String, String> {
    let program = compile(root)?;
    let arguments = [millihertz.to_string(), TICKS.to_string()];
    let mut command = qemu::counting(&program, &arguments);
    let output = command.output().map_err(|error| format!("{}: {error}", qemu::PROGRAM))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(text)
    } else {
        Err(format!("xtask/floor/tick.c: {}\n{text}", output.status))
    }
}

fn compile(root: &Path) -> Result<PathBuf, String> {
    let program = install::target_directory(root).join("tick");
    let mut compiler = cross::compiler(root);
    compiler.args(["-std=c99", "-O3"]).args(cross::STRICT).arg(root.join("xtask/floor/tick.c"));
    driven::output(compiler.arg("-o").arg(&program)).map(|_| program)
}
