//! Audit of everything from outside: licences, sources and bans of every crate.

use crate::install;
use narx_report::steps;
use std::path::Path;
use std::process::{Command, ExitCode};

/// Version of cargo-deny that gives the verdict.
const CARGO_DENY: &str = "0.20.2";

/// Checks every crate of `Cargo.lock` against `deny.toml`.
pub(crate) fn command(root: &Path) -> ExitCode {
    steps::finish(audit(root))
}

fn audit(root: &Path) -> steps::Outcome {
    install::cargo_program("cargo-deny", CARGO_DENY)?;
    let mut deny = Command::new("cargo");
    steps::run(
        deny.args(["deny", "--workspace", "--log-level", "error", "check", "bans", "licenses", "sources"])
            .current_dir(root),
    )
}
