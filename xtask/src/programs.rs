//! Programs of ours that carry out a part of the commands: built when they are called.

use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// A program: the package, whose only binary has the same name, and the profile in which it is built.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Program(&'static str, &'static str);

/// The demonstration, the virtual drive, and the signing of images.
pub(crate) const TERMINAL: Program = Program("narx-terminal", "desk");
/// Experiments on the bench: what a test or a generated file needs of them takes seconds.
pub(crate) const LAB: Program = Program("narx-lab", "desk");
/// Experiments that run for hours, or that measure how fast they run.
pub(crate) const LAB_RELEASE: Program = Program("narx-lab", "release");
/// Files that follow from the code.
pub(crate) const GENERATE: Program = Program("narx-generate", "desk");

impl Program {
    /// Returns a call that builds the program and runs it.
    fn call(self, root: &Path, arguments: &[impl AsRef<OsStr>]) -> Command {
        let mut cargo = Command::new("cargo");
        let manifest = root.join("Cargo.toml");
        cargo.args(["run", "--quiet", "--manifest-path"]).arg(manifest);
        cargo.args(["--package", self.0, "--profile", self.1, "--"]).args(arguments);
        cargo
    }

    /// Runs the program; returns its closing lines, those after its last empty line.
    ///
    /// # Errors
    /// Fails if it does not build, start or succeed.
    pub(crate) fn run(self, root: &Path, arguments: &[impl AsRef<OsStr>]) -> Outcome {
        let mut closing = Vec::new();
        steps::watch(&mut self.call(root, arguments), |line| {
            if line.is_empty() {
                closing.clear();
            } else {
                closing.push(line.to_owned());
            }
        })?;
        Ok(closing)
    }

    /// Lets the program take the place of this one, so that it gets signals and gives the exit code.
    pub(crate) fn hand_over(self, root: &Path, arguments: &[impl AsRef<OsStr>]) -> ExitCode {
        let mut call = self.call(root, arguments);
        #[cfg(unix)]
        let failed = std::os::unix::process::CommandExt::exec(&mut call);
        #[cfg(not(unix))]
        let failed = match call.status() {
            Ok(status) => return ExitCode::from(status.code().unwrap_or(1) as u8),
            Err(error) => error,
        };
        eprintln!("cargo: {failed}");
        ExitCode::FAILURE
    }

    /// Builds the program; returns its path.
    ///
    /// # Errors
    /// Fails with the compiler's message.
    pub(crate) fn build(self, root: &Path) -> Result<PathBuf, String> {
        let mut cargo = Command::new("cargo");
        cargo.args(["build", "--quiet", "--package", self.0, "--profile", self.1]);
        steps::run(cargo.current_dir(root))?;
        Ok(target_directory(root).join(self.1).join(self.0))
    }
}
