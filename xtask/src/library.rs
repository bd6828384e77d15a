//! The static libraries for C: for this machine and for every processor.

use crate::cross::Processor;
use crate::install::{self, target_directory};
use crate::steps::{self, Outcome};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What a C library is for: this machine or a processor.
pub const ALL: [Option<Processor>; 3] = [None, Some(Processor::CortexM4F), Some(Processor::CortexM0)];

/// `libnarx.a`.
pub const NARX: Library = Library { package: "narx-ffi", name: "narx" };
/// The same with a simulated motor: `libnarx_bench.a`.
pub const BENCH: Library = Library { package: "narx-c-bench", name: "narx_bench" };

/// A static library of ours.
#[derive(Clone, Copy, Debug)]
pub struct Library {
    package: &'static str,
    name: &'static str,
}

impl Library {
    /// Builds it as released.
    ///
    /// # Errors
    /// What the compiler said.
    pub fn build(self, root: &Path, processor: Option<Processor>) -> Outcome {
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

    /// The shared library of this machine.
    pub fn shared(self, root: &Path) -> PathBuf {
        target_directory(root).join("release").join(format!("lib{}.so", self.name))
    }

    /// Where it stands then.
    pub fn path(self, root: &Path, processor: Option<Processor>) -> PathBuf {
        let mut path = target_directory(root);
        path.extend(processor.map(Processor::target));
        path.join("release").join(format!("lib{}.a", self.name))
    }
}
