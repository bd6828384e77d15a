//! Tools that a part needs beside Rust: present, installed on `--all`, or named.

use super::Context;
use crate::install::{self, Package};
use crate::test::python;
use std::path::{Path, PathBuf};

/// Checks for the programs of the packages, or installs them.
pub(super) fn debian(context: &Context<'_>, packages: &[Package]) -> Result<(), String> {
    if context.all {
        return install::debian(packages).map(drop);
    }
    let missing: Vec<&str> =
        packages.iter().filter(|package| !package.is_there()).map(|package| package.name).collect();
    if missing.is_empty() { Ok(()) } else { Err(format!("needs {}; --all installs it", missing.join(", "))) }
}

/// Interpreter of the environment in which the Python tests run, with the present package.
pub(super) fn python_package(context: &Context<'_>) -> Result<PathBuf, String> {
    python_environment(context, &python::directory(context.root))?;
    python::prepare(context.root)
}

/// Checks for an environment that exists, or that may be made.
pub(super) fn python_environment(context: &Context<'_>, directory: &Path) -> Result<(), String> {
    if context.all || directory.join("installed.txt").exists() {
        return Ok(());
    }
    Err("needs a Python environment; --all makes it".into())
}

/// Checks for Node and the packages of the page.
pub(super) fn node(context: &Context<'_>) -> Result<(), String> {
    debian(context, &install::NODE)?;
    if context.all || context.root.join("wasm/web/node_modules").exists() {
        return Ok(());
    }
    Err("needs the page's npm packages; --all installs them".into())
}
