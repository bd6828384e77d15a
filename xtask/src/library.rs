//! The static libraries for C: for this machine and for every processor.

use crate::cross::Processor;
use crate::install;
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Targets of a C library: this machine (`None`) and every processor.
pub(crate) const ALL: [Option<Processor>; 3] = [None, Some(Processor::CortexM4F), Some(Processor::CortexM0)];

/// `libnarx.a`.
pub(crate) const NARX: Library = Library { package: "narx-ffi", name: "narx" };
/// `libnarx_bench.a`: the same with a simulated motor.
pub(crate) const BENCH: Library = Library { package: "narx-c-bench", name: "narx_bench" };

/// A static library of ours.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Library {
    package: &'static str,
    name: &'static str,
}

impl Library {
    /// Builds it in its release profile.
    ///
    /// # Errors
    /// Fails with the compiler's message.
    pub(crate) fn build(self, root: &Path, processor: Option<Processor>) -> Outcome {
        let mut cargo = Command::new("cargo");
        cargo.args(["rustc", "--quiet", "--release", "-p", self.package, "--lib"]);
        if let Some(processor) = processor {
            install::rust_target(processor.target())?;
            cargo.args(["--target", processor.target()]);
        }
        // Bare metal has no shared libraries.
        let kinds = if processor.is_some() { "staticlib" } else { "staticlib,cdylib" };
        steps::run(cargo.args(["--crate-type", kinds]).current_dir(root))
    }

    /// Path of the shared library of this machine.
    pub(crate) fn shared(self, root: &Path) -> PathBuf {
        target_directory(root).join("release").join(format!("lib{}.so", self.name))
    }

    /// Path of the built library.
    pub(crate) fn path(self, root: &Path, processor: Option<Processor>) -> PathBuf {
        let mut path = target_directory(root);
        path.extend(processor.map(Processor::target));
        path.join("release").join(format!("lib{}.a", self.name))
    }
}
