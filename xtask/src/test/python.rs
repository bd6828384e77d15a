//! The Python package: installed into an environment of its own, its stubs checked, its tests run.

use crate::install;
use crate::replayer::{ARGUMENTS, Replayer};
use narx_report::steps::{self, Outcome, Step};
use narx_report::target_directory;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Mutex, PoisonError};
use std::{fs, io};

/// Steps in their order.
pub(crate) fn steps(root: &Path) -> Vec<Step<'_>> {
    let mut steps = docs(root);
    steps.push(Step::new("Python stubs", move || stubs(root)));
    steps.push(Step::new("Python tests", move || {
        module(root, &["pytest", "--color=no", "-p", "no:cacheprovider"], &[tests(root)])
    }));
    steps
}

/// Steps that build the package's reference.
pub(crate) fn docs(root: &Path) -> Vec<Step<'_>> {
    vec![
        Step::new("Python package", move || prepare(root).map(|_| Vec::new())),
        Step::new("Python reference", move || reference(root)),
    ]
}

/// Programs that replay recordings, once [`steps`] has built them.
pub(crate) fn replayers(root: &Path) -> Vec<Replayer> {
    let mut command = Command::new(python(root));
    vec![Replayer::new("Python", command.arg(tests(root).join("replay.py")).arg(ARGUMENTS))]
}

/// Interpreter of an environment with the package in it, which is installed once in a run: tests of two
/// targets need it, and may run side by side.
///
/// # Errors
/// Fails with the message of Python, pip or cargo.
pub(crate) fn prepare(root: &Path) -> Result<PathBuf, String> {
    static INSTALLED: Mutex<bool> = Mutex::new(false);
    let mut installed = INSTALLED.lock().unwrap_or_else(PoisonError::into_inner);
    if !*installed {
        install::python_environment(&directory(root), &tests(root).join("requirements.txt"))?;
        let pip = ["pip", "install", "--quiet", "--force-reinstall", "--no-deps"];
        module(root, &pip, &[root.join("python")])?;
        *installed = true;
    }
    Ok(python(root))
}

/// Checks that the stubs match the compiled module, and that package and tests agree with the stubs.
fn stubs(root: &Path) -> Outcome {
    let package = root.join("python");
    let settings = package.join("pyproject.toml").display().to_string();
    module(root, &["mypy.stubtest", "narx", "--mypy-config-file", &settings], &[])?;
    let mypy = ["mypy", "--no-incremental", "--config-file", &settings];
    module(root, &mypy, &[package.join("narx"), tests(root)])?;
    Ok(Vec::new())
}

/// Builds the reference from the docstrings, a page per class; a warning is an error.
fn reference(root: &Path) -> Outcome {
    let (settings, made) = (root.join("python/docs"), target_directory(root).join("docs/python"));
    let source = made.join("source");
    let failed = |error: io::Error| format!("{}: {error}", made.display());
    // Pages of removed items must go.
    if made.exists() {
        fs::remove_dir_all(&made).map_err(failed)?;
    }
    fs::create_dir_all(&source).map_err(failed)?;
    fs::copy(settings.join("index.rst"), source.join("index.rst")).map_err(failed)?;
    let sphinx = ["sphinx", "--quiet", "--fail-on-warning", "--keep-going", "--conf-dir"];
    module(root, &sphinx, &[settings, source, made.join("html")])?;
    Ok(vec![made.join("html/index.html").display().to_string()])
}

/// Runs a module of the environment.
fn module(root: &Path, arguments: &[&str], paths: &[PathBuf]) -> Outcome {
    let mut command = Command::new(python(root));
    command.arg("-m").args(arguments).args(paths);
    // Builds and caches stay under `target/`.
    command.env("CARGO_TARGET_DIR", target_directory(root)).env("PYTHONDONTWRITEBYTECODE", "1");
    steps::run(command.current_dir(directory(root)))
}

/// Folder of the environment.
pub(crate) fn directory(root: &Path) -> PathBuf {
    target_directory(root).join("python-environment")
}

fn python(root: &Path) -> PathBuf {
    directory(root).join("bin/python")
}

fn tests(root: &Path) -> PathBuf {
    root.join("tests/python")
}
