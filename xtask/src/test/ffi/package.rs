//! A release in another project: found by CMake, built and run.

use super::build::directory;
use crate::archive;
use crate::cross::Processor;
use crate::library::Released;
use narx_report::steps::Outcome;
use narx_report::steps::output;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Lays a release of these libraries out and uses it: runs the consumer's program on this machine, links it
/// for every processor, and checks that CMake refuses a processor for which there is no library.
pub(super) fn consumed(root: &Path, libraries: &[Released]) -> Outcome {
    let release = archive::lay_out(root, libraries)?;
    let program = built(root, &release, "x86_64", &[])?;
    let mut lines = output(&mut Command::new(program))?;
    // The example that people copy.
    let example = directory(root).join("consumer/example");
    configured(&root.join("examples/cmake"), &example, &release, &[])?;
    lines += &output(&mut Command::new(example.join("drive")))?;
    let processors = ["cortex-m4", "cortex-m0", "cortex-m3", "cortex-m33", "riscv32"];
    for (name, processor) in processors.into_iter().zip(Processor::ALL) {
        let flags = processor.options().join(" ");
        built(
            root,
            &release,
            name,
            &[
                format!("-DCMAKE_C_FLAGS={flags} {}", processor.library()),
                format!("-DCMAKE_C_COMPILER={}", processor.tool("gcc")),
            ],
        )?;
    }
    match built(root, &release, "cortex-r5", &["-DCMAKE_C_COMPILER=arm-none-eabi-gcc".to_owned()]) {
        Err(reason) if reason.contains("no library for NARX_TARGET") => {}
        other => return Err(format!("for a cortex-r5 there is no library, and CMake says: {other:?}")),
    }
    Ok(lines.lines().map(str::to_owned).collect())
}

/// Builds the consumer's program for a processor.
fn built(root: &Path, release: &Path, processor: &str, options: &[String]) -> Result<PathBuf, String> {
    let folder = directory(root).join("consumer").join(processor);
    let mut options = options.to_vec();
    if processor != "x86_64" {
        options.extend(
            ["-DCMAKE_SYSTEM_NAME=Generic", "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY"]
                .map(String::from),
        );
        options.push(format!("-DCMAKE_SYSTEM_PROCESSOR={processor}"));
    }
    configured(&root.join("tests/c/consumer"), &folder, release, &options)?;
    Ok(folder.join("consumer"))
}

/// Builds the project in `source` against the release.
fn configured(source: &Path, folder: &Path, release: &Path, options: &[String]) -> Result<(), String> {
    // The results of the last search must not be used again.
    let _ = fs::remove_dir_all(folder);
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(source).arg("-B").arg(folder).args(options);
    output(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", release.display())))?;
    output(Command::new("cmake").arg("--build").arg(folder)).map(drop)
}
