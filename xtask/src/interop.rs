//! Tests of our files with other people's tools: python-can reads the logs and commands the virtual drive,
//! cantools reads the database, xmlschema the description, python-canopen the EDS of the TX-Driver, with
//! which it commands TX-Drivers on the virtual drive's bus.

use crate::install;
use crate::programs::{GENERATE, TERMINAL};
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use std::path::Path;
use std::process::Command;

/// Writes the samples, prepares a Python environment under `target/` and runs `tests/interop` in it.
pub(crate) fn run(root: &Path) -> Outcome {
    let target = target_directory(root);
    let samples = target.join("interop");
    GENERATE.run(root, &["samples".as_ref(), samples.as_os_str()])?;
    let terminal = TERMINAL.build(root)?;
    let mut demo = Command::new(&terminal);
    demo.args(["demo", "--seconds", "1.5", "--rpm", "2000", "--out"]).arg(samples.join("demo"));
    steps::run(&mut demo)?;
    let tests = root.join("tests/interop");
    let python =
        install::python_environment(&target.join("interop-python"), &tests.join("requirements.txt"))?;
    steps::run(
        Command::new(python)
            .args(["-m", "pytest", "--color=no", "-p", "no:cacheprovider"])
            .arg(&tests)
            .env("NARX_INTEROP", &samples)
            .env("NARX_TERMINAL", &terminal)
            .env("PYTHONDONTWRITEBYTECODE", "1"),
    )
}
