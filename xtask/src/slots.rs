//! Images for the slots of the emulated board, signed with the public test key.

use crate::image::Image;
use crate::programs::TERMINAL;
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Secret half of the key that the emulated board believes; everybody has it.
const TEST_KEY: &str = "boot/keys/TEST-ONLY.key";

/// Folder in which [`make`] leaves the images.
pub(crate) fn directory(root: &Path) -> PathBuf {
    target_directory(root).join("slots")
}

/// Makes images of the virtual drive: `old` and `new`, and `foreign`, which is like `new` but signed by a
/// foreign key. Also makes `idle`, short enough to be sent in seconds: a program that only loops, so that
/// nothing can confirm it.
///
/// # Errors
/// Fails with the message of the signing.
pub(crate) fn make(root: &Path) -> Outcome {
    let directory = directory(root);
    fs::create_dir_all(&directory).map_err(|error| format!("{}: {error}", directory.display()))?;
    let (idle, drive) = (directory.join("idle.bin"), Image::Application.path(root));
    fs::write(&idle, idle_program()).map_err(|error| format!("{}: {error}", idle.display()))?;
    // A key that no board accepts.
    let foreign = directory.join("foreign.key");
    fs::write(&foreign, "07".repeat(32)).map_err(|error| format!("{}: {error}", foreign.display()))?;
    let (test, sign) = (root.join(TEST_KEY), TERMINAL.build(root)?);
    let mut lines = Vec::new();
    for (name, program, key, version) in [
        ("old", &drive, &test, "1.1.0+1"),
        ("new", &drive, &test, "1.2.0+2"),
        ("foreign", &drive, &foreign, "1.2.0+2"),
        ("idle", &idle, &test, "1.2.0+2"),
    ] {
        let mut command = Command::new(&sign);
        command.arg("sign").arg(program).arg("--key").arg(key);
        command.args(["--hardware", "qemu", "--version", version]);
        command.arg("--out").arg(directory.join(name).with_extension("narximg"));
        lines.push(steps::output(&mut command)?.trim().to_owned());
    }
    Ok(lines)
}

/// Program with the vectors of stack and reset, a branch to itself, and bytes of all kinds.
fn idle_program() -> Vec<u8> {
    const ENTRY: u32 = 0x2100_0200;
    const BRANCH_TO_ITSELF: u16 = 0xE7FE;
    let mut program = [0x203F_F000, ENTRY + 8 + 1].map(u32::to_le_bytes).concat();
    program.extend(BRANCH_TO_ITSELF.to_le_bytes());
    program.extend((0..12_000_u32).map(|at| (at.wrapping_mul(0x9E37_79B9) >> 24) as u8));
    program
}
