//! A release in another project: found by CMake, built and run.

use super::build::directory;
use crate::archive;
use crate::cross::{self, Processor};
use narx_report::steps::Outcome;
use narx_report::steps::output;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Lays a release out and uses it: runs the consumer's program on this machine, links it for every processor,
/// and checks that CMake refuses a processor for which there is no library.
pub(super) fn consumed(root: &Path) -> Outcome {
    let release = archive::lay_out(root)?;
    let program = built(root, &release, "x86_64", &[])?;
    let lines = output(&mut Command::new(program))?;
    for (name, processor) in [("cortex-m4", Processor::CortexM4F), ("cortex-m0", Processor::CortexM0)] {
        let options = format!("-DCMAKE_C_FLAGS={} --specs=nosys.specs", processor.options().join(" "));
        built(root, &release, name, &[options])?;
    }
    match built(root, &release, "cortex-m33", &[]) {
        Err(reason) if reason.contains("no library for NARX_TARGET") => {}
        other => return Err(format!("for a cortex-m33 there is no library, and CMake says: {other:?}")),
    }
    Ok(lines.lines().map(str::to_owned).collect())
}

/// Builds the consumer's program for a processor.
fn built(root: &Path, release: &Path, processor: &str, options: &[String]) -> Result<PathBuf, String> {
    let folder = directory(root).join("consumer").join(processor);
    // The results of the last search must not be used again.
    let _ = fs::remove_dir_all(&folder);
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(root.join("tests/c/consumer")).arg("-B").arg(&folder).args(options);
    configure.arg(format!("-DCMAKE_PREFIX_PATH={}", release.display()));
    if processor != "x86_64" {
        configure.args(["-DCMAKE_SYSTEM_NAME=Generic", "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY"]);
        configure.arg(format!("-DCMAKE_SYSTEM_PROCESSOR={processor}"));
        configure.arg(format!("-DCMAKE_C_COMPILER={}", cross::COMPILER));
    }
    output(&mut configure)?;
    output(Command::new("cmake").arg("--build").arg(&folder))?;
    Ok(folder.join("consumer"))
}
