//! Tests of the two halves of a drive at once: under ThreadSanitizer with C on either side of the interface,
//! and in Miri.

use super::build::made_directory;
use crate::cross::STRICT;
use crate::install;
use narx_report::steps::output;
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use std::path::{Path, PathBuf};
use std::process::Command;

const TARGET: &str = "x86_64-unknown-linux-gnu";
/// Exit code of a program that ThreadSanitizer has complained of.
const COMPLAINED: i32 = 66;

/// Runs `tests/c/threads.c` under ThreadSanitizer: it must not complain of the two halves on two threads, and
/// must complain of two threads in one half. The library and the standard library below it are built anew, so
/// that every access of theirs is instrumented; this needs nightly Rust.
pub(super) fn sanitized(root: &Path) -> Outcome {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        return Ok(vec!["not run: made for Linux on x86-64".into()]);
    }
    install::nightly(&["rust-src"])?;
    let target = target_directory(root).join("thread-sanitizer");
    let mut cargo = Command::new("cargo");
    cargo.args(["+nightly", "rustc", "--quiet", "-p", "narx-ffi", "--lib", "--crate-type", "staticlib"]);
    cargo.args(["-Zbuild-std", "--target", TARGET]).current_dir(root);
    cargo.env("CARGO_TARGET_DIR", &target).env("RUSTFLAGS", "-Zsanitizer=thread --cfg thread_sanitizer");
    steps::run(&mut cargo)?;
    let program = made_directory(root)?.join("threads");
    let mut compiler = Command::new("gcc");
    compiler.args(["-std=gnu99", "-O1", "-g"]).args(STRICT).arg("-I").arg(root.join("ffi/include"));
    // Instrumented by gcc; the runtime is Rust's, which supports both compilers.
    compiler.args(["-fsanitize=thread", "-c"]).arg(root.join("tests/c/threads.c"));
    let object = program.with_extension("o");
    steps::run(compiler.arg("-o").arg(&object))?;
    let mut linker = Command::new("gcc");
    linker.arg(&object).arg(target.join(TARGET).join("debug/libnarx.a")).arg(runtime()?);
    steps::run(linker.args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&program))?;
    let lines = output(&mut Command::new(&program))?;
    // The first complaint suffices; two competing threads would cause complaints for a minute.
    let mut misuse = Command::new(&program);
    let misuse = misuse.arg("--misuse").env("TSAN_OPTIONS", "halt_on_error=1");
    let misuse = misuse.output().map_err(|error| error.to_string())?;
    if misuse.status.code() != Some(COMPLAINED) {
        return Err(format!("threads --misuse: {}: the sanitizer sees nothing", misuse.status));
    }
    Ok(lines.lines().map(str::to_owned).collect())
}

/// Runs the same halves in Miri, which checks the rules for references: `ffi/tests/halves.rs`.
pub(super) fn interpreted(root: &Path) -> Outcome {
    install::nightly(&["miri", "rust-src"])?;
    let mut cargo = Command::new("cargo");
    cargo.args(["+nightly", "miri", "test", "--quiet", "-p", "narx-ffi", "--test", "halves"]);
    cargo.current_dir(root).env("CARGO_TARGET_DIR", target_directory(root).join("miri"));
    steps::run(&mut cargo)
}

/// Path of ThreadSanitizer's runtime library, which comes with Rust.
fn runtime() -> Result<PathBuf, String> {
    let root = output(Command::new("rustc").args(["+nightly", "--print", "sysroot"]))?;
    let libraries = Path::new(root.trim()).join("lib/rustlib").join(TARGET).join("lib");
    let entries = libraries.read_dir().map_err(|error| format!("{}: {error}", libraries.display()))?;
    let mut files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let is_it = |path: &PathBuf| path.to_string_lossy().ends_with("_rt.tsan.a");
    files.find(is_it).ok_or_else(|| format!("no runtime of ThreadSanitizer in {}", libraries.display()))
}
