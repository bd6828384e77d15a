//! Images for the slots of the emulated board and of the B-G431B-ESC1, signed with the public test key.

use crate::board;
use crate::image::Image;
use crate::programs::TERMINAL;
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Secret half of the key that these boards believe in tests; everybody has it.
const TEST_KEY: &str = "boot/keys/TEST-ONLY.key";

/// Folder in which [`make`] leaves the images.
pub(crate) fn directory(root: &Path) -> PathBuf {
    target_directory(root).join("slots")
}

/// Folder in which [`make_for_board`] leaves the images.
pub(crate) fn directory_of_board(root: &Path) -> PathBuf {
    directory(root).join("b-g431b-esc1")
}

/// Signs programs with the public test key; `foreign` by a key that no board accepts.
struct Signing<'a> {
    root: &'a Path,
    directory: PathBuf,
    hardware: &'a str,
}

impl Signing<'_> {
    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<PathBuf, String> {
        let path = self.directory.join(name);
        fs::create_dir_all(&self.directory)
            .and_then(|()| fs::write(&path, bytes))
            .map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(path)
    }

    /// Signs (name, program, version).
    fn sign(&self, images: &[(&str, &Path, &str)]) -> Outcome {
        let foreign = self.write("foreign.key", "07".repeat(32))?;
        let (test, sign) = (self.root.join(TEST_KEY), TERMINAL.build(self.root)?);
        let mut lines = Vec::new();
        for (name, program, version) in images {
            let key = if *name == "foreign" { &foreign } else { &test };
            let mut command = Command::new(&sign);
            command.arg("sign").arg(program).arg("--key").arg(key);
            command.args(["--hardware", self.hardware, "--version", version]);
            command.arg("--out").arg(self.directory.join(name).with_extension("narximg"));
            lines.push(steps::output(&mut command)?.trim().to_owned());
        }
        Ok(lines)
    }
}

/// Makes images of the virtual drive: `old` and `new`, and `foreign`, which is like `new` but signed by a
/// foreign key. Also makes `idle`, short enough to be sent in seconds: a program that only loops, so that
/// nothing can confirm it.
///
/// # Errors
/// Fails with the message of the signing.
pub(crate) fn make(root: &Path) -> Outcome {
    let signing = Signing { root, directory: directory(root), hardware: "qemu" };
    let idle = signing.write("idle.bin", idle_program(0x203F_F000, 0x2100_0200))?;
    let drive = &Image::Application.path(root);
    signing.sign(&[
        ("old", drive, "1.1.0+1"),
        ("new", drive, "1.2.0+2"),
        ("foreign", drive, "1.2.0+2"),
        ("idle", &idle, "1.2.0+2"),
    ])
}

/// Makes images of the board B-G431B-ESC1: `old`, `foreign`, which is a later version by a foreign key, and
/// `idle`.
///
/// # Errors
/// Fails with the message of the signing.
pub(crate) fn make_for_board(root: &Path) -> Outcome {
    let signing = Signing { root, directory: directory_of_board(root), hardware: "b-g431b-esc1" };
    let idle = signing.write("idle.bin", idle_program(0x2000_8000, 0x0800_5A00))?;
    let drive = &board::path(root, "drive");
    signing.sign(&[("old", drive, "1.1.0+1"), ("foreign", drive, "1.2.0+2"), ("idle", &idle, "1.2.0+2")])
}

/// Program for the address `entry` with the vectors of stack and reset, a branch to itself, and bytes of all
/// kinds.
fn idle_program(stack: u32, entry: u32) -> Vec<u8> {
    const BRANCH_TO_ITSELF: u16 = 0xE7FE;
    let mut program = [stack, entry + 8 + 1].map(u32::to_le_bytes).concat();
    program.extend(BRANCH_TO_ITSELF.to_le_bytes());
    program.extend((0..12_000_u32).map(|at| (at.wrapping_mul(0x9E37_79B9) >> 24) as u8));
    program
}
