//! The static libraries for C: for this machine and for every processor, fast or small.

use crate::cross::Processor;
use crate::install;
use narx_report::steps::{self, Outcome, output};
use narx_report::target_directory;
use std::path::{Path, PathBuf};
use std::process::Command;

/// `libnarx.a`.
pub(crate) const NARX: Library = Library { package: "narx-ffi", name: "narx", profile: "release" };
/// `libnarx.a` for little flash: the same bits in less code, by opt-level z.
pub(crate) const SMALL: Library = Library { profile: "small", ..NARX };
/// `libnarx_bench.a`: the same with a simulated motor.
pub(crate) const BENCH: Library = Library { package: "narx-c-bench", name: "narx_bench", ..NARX };

/// A library for this machine (`None`) or a processor, in a release.
pub(crate) type Released = (Library, Option<Processor>);

/// The libraries of a release: this machine has memory enough for the fast one.
pub(crate) fn released() -> Vec<Released> {
    let each = |library| Processor::ALL.map(|processor| (library, Some(processor)));
    [(NARX, None)].into_iter().chain(each(NARX)).chain(each(SMALL)).collect()
}

/// A static library of ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Library {
    package: &'static str,
    name: &'static str,
    profile: &'static str,
}

impl Library {
    /// Builds it.
    ///
    /// # Errors
    /// Fails with the compiler's message.
    pub(crate) fn build(self, root: &Path, processor: Option<Processor>) -> Outcome {
        self.build_with(root, processor, &[])
    }

    /// Builds it for a processor with some of its features alone.
    ///
    /// # Errors
    /// Fails with the compiler's message.
    pub(crate) fn build_part(self, root: &Path, processor: Processor, features: &[&str]) -> Outcome {
        self.build_with(root, Some(processor), &["--no-default-features", "--features", &features.join(",")])
    }

    fn build_with(self, root: &Path, processor: Option<Processor>, features: &[&str]) -> Outcome {
        let mut cargo = Command::new("cargo");
        cargo
            .args(["rustc", "--quiet", "--profile", self.profile, "-p", self.package, "--lib"])
            .args(features);
        if let Some(processor) = processor {
            install::rust_target(processor.target())?;
            cargo.args(["--target", processor.target()]);
        }
        // Bare metal has no shared libraries.
        let kinds = if processor.is_some() { "staticlib" } else { "staticlib,cdylib" };
        steps::run(cargo.args(["--crate-type", kinds]).current_dir(root))?;
        if let Some(processor) = processor {
            leave_memory_functions_to_c(&self.path(root, Some(processor)), processor)?;
        }
        Ok(Vec::new())
    }

    /// Name of its file in a release.
    pub(crate) fn file(self) -> &'static str {
        if self.profile == SMALL.profile { "libnarx-small.a" } else { "libnarx.a" }
    }

    /// Path of the shared library of this machine.
    pub(crate) fn shared(self, root: &Path) -> PathBuf {
        target_directory(root).join(self.profile).join(format!("lib{}.so", self.name))
    }

    /// Path of the built library.
    pub(crate) fn path(self, root: &Path, processor: Option<Processor>) -> PathBuf {
        let mut path = target_directory(root);
        path.extend(processor.map(Processor::target));
        path.join(self.profile).join(format!("lib{}.a", self.name))
    }
}

/// Takes memcpy, memset and their like out of a library: every C library for bare metal has them in a tenth
/// of the 1.5 KB that Rust's take.
fn leave_memory_functions_to_c(library: &Path, processor: Processor) -> Result<(), String> {
    let symbols = output(Command::new(processor.tool("readelf")).arg("-sW").arg(library))?;
    let (mut member, mut spare) = ("", Vec::new());
    for line in symbols.lines() {
        if let Some((_, name)) = line.split_once(".a(") {
            member = name.trim_end_matches(')');
        }
        let words: Vec<&str> = line.split_whitespace().collect();
        if let [_, _, _, "FUNC", "WEAK", _, _, name] = words[..]
            && (name.starts_with("mem")
                || name.starts_with("__aeabi_mem")
                || ["bcmp", "strlen"].contains(&name))
        {
            spare.push(member);
        }
    }
    if spare.is_empty() {
        return Ok(());
    }
    output(Command::new(processor.tool("ar")).arg("d").arg(library).args(spare)).map(drop)
}
