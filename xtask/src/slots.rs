//! Images for the slots of the emulated board, signed with the public test key.

use crate::firmware::Image;
use crate::install;
use crate::sign;
use crate::steps::Outcome;
use narx_boot::sign::SecretKey;
use narx_boot::{Version, hardware};
use std::fs;
use std::path::{Path, PathBuf};

/// A key that no board accepts.
const FOREIGN: SecretKey = SecretKey([7; 32]);

/// Folder in which [`make`] leaves the images.
pub fn directory(root: &Path) -> PathBuf {
    install::target_directory(root).join("slots")
}

/// Makes images of the virtual drive: `old` and `new`, and `foreign`, which is like `new` but signed by a
/// foreign key. Also makes `idle`, short enough to be sent in seconds: a program that only loops, so that
/// nothing can confirm it.
///
/// # Errors
/// Fails with the message of the signing.
pub fn make(root: &Path) -> Outcome {
    let directory = directory(root);
    fs::create_dir_all(&directory).map_err(|error| format!("{}: {error}", directory.display()))?;
    let (idle, drive) = (directory.join("idle.bin"), Image::Application.path(root));
    fs::write(&idle, idle_program()).map_err(|error| format!("{}: {error}", idle.display()))?;
    let mut lines = Vec::new();
    for (name, program, key, minor) in [
        ("old", &drive, SecretKey::TEST_ONLY, 1),
        ("new", &drive, SecretKey::TEST_ONLY, 2),
        ("foreign", &drive, FOREIGN, 2),
        ("idle", &idle, SecretKey::TEST_ONLY, 2),
    ] {
        let version = Version { major: 1, minor, patch: 0, build: minor.into() };
        let path = directory.join(name).with_extension("narximg");
        lines.extend(sign::sign(program, &key, hardware::QEMU, version, &path)?);
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
