//! C programs under checking tools: sanitizers, valgrind, cppcheck.

use super::build::{Build, directory};
use super::{CHECKS, REPLAY};
use crate::vectors;
use narx_report::steps::{self, Outcome};
use std::path::Path;
use std::process::Command;

/// Runs the programs under AddressSanitizer and UndefinedBehaviorSanitizer, with all vectors; the digests are
/// compared elsewhere. The library itself is not instrumented: valgrind and Miri check its memory.
pub(super) fn sanitized(root: &Path) -> Outcome {
    let mut replay = Build::Sanitized.start(root, REPLAY, &[]);
    steps::run(replay.args(vectors::recordings(root)?))?;
    super::run(root, Build::Sanitized)
}

/// Runs program and library under valgrind: no access outside of the given memory, no use of uninitialised
/// values, no leak.
pub(super) fn valgrind(root: &Path) -> Outcome {
    let mut lines = Vec::new();
    for source in CHECKS {
        let mut command = Command::new("valgrind");
        command.args(["--quiet", "--error-exitcode=9", "--leak-check=full", "--errors-for-leak-kinds=all"]);
        lines.extend(steps::run(command.arg(Build::Gcc.program(root, source)))?);
    }
    Ok(lines)
}

/// Checks every C file of ours, and the header.
pub(super) fn cppcheck(root: &Path) -> Outcome {
    let build = directory(root).join("cppcheck");
    std::fs::create_dir_all(&build).map_err(|error| format!("{}: {error}", build.display()))?;
    let mut command = Command::new("cppcheck");
    command.args(["--quiet", "--std=c99", "--error-exitcode=1", "--inline-suppr"]);
    command.arg("--enable=warning,style,performance,portability");
    command.args(["--suppress=missingIncludeSystem", "--library=posix"]);
    // The processor and the emulator read these members.
    command.args(["--suppress=unusedStructMember:*start.c", "--suppress=unusedStructMember:*arm.c"]);
    command.arg(format!("--cppcheck-build-dir={}", build.display()));
    let folders = ["ffi/include", "ffi/examples", "tests/c"].map(|folder| root.join(folder));
    command.args(folders.iter().map(|folder| format!("-I{}", folder.display())));
    steps::run(command.args(&folders))
}
