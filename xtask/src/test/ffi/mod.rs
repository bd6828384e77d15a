//! The C library: C programs on this machine, also under everything that watches programs there, and on emulated microcontrollers.

mod build;
mod threads;
mod watched;

use crate::cross::{self, Processor, STRICT};
use crate::install::{self, Package};
use crate::parity::Replayer;
use crate::steps::{self, Outcome, Step};
use crate::{header, qemu};
use build::Build;
use std::path::Path;
use std::process::Command;

/// What the tests need from Debian.
const PACKAGES: [Package; 8] = [
    Package { name: "gcc", provides: "gcc" },
    Package { name: "g++", provides: "g++" },
    Package { name: "clang", provides: "clang" },
    Package { name: "cppcheck", provides: "cppcheck" },
    Package { name: "valgrind", provides: "valgrind" },
    cross::PACKAGES[0],
    cross::PACKAGES[1],
    Package { name: "qemu-system-arm", provides: qemu::PROGRAM },
];

/// A drive in C: what it does, and every misuse.
const DRIVE: &str = "tests/c/drive.c";
/// Both protocols from both ends.
const PROTOCOL: &str = "tests/c/protocol.c";
/// Programs that check themselves.
const CHECKS: [&str; 2] = [DRIVE, PROTOCOL];
/// Replays recordings.
const REPLAY: &str = "tests/c/replay.c";

/// What is run, in order.
pub fn steps(root: &Path) -> Vec<Step<'_>> {
    vec![
        Step::new("C header", move || header::regenerate(root, true)),
        Step::new("C tools", || install::debian(&PACKAGES)),
        Step::new("C targets", || {
            Processor::ALL
                .iter()
                .try_for_each(|processor| install::rust_target(processor.target()).map(drop))?;
            Ok(Vec::new())
        }),
        Step::new("C library", move || libraries(root)),
        Step::new("C programs", move || programs(root)),
        Step::new("C on x86-64", move || Ok([run(root, Build::Gcc)?, run(root, Build::Clang)?].concat())),
        Step::new("C sanitized", move || watched::sanitized(root)),
        Step::new("C valgrind", move || watched::valgrind(root)),
        Step::new("C cppcheck", move || watched::cppcheck(root)),
        Step::new("C threads", move || threads::sanitized(root)),
        Step::new("C halves in Miri", move || threads::interpreted(root)),
        Step::new("C on Cortex-M4F", move || run(root, Build::CortexM4F)),
        Step::new("C on Cortex-M0", move || run(root, Build::CortexM0)),
    ]
}

/// Runs every program that checks itself.
fn run(root: &Path, build: Build) -> Outcome {
    let mut lines = Vec::new();
    for source in CHECKS {
        lines.extend(build.run(root, source)?);
    }
    Ok(lines)
}

/// What replays recordings, once [`steps`] have built it.
pub fn replayers(root: &Path) -> Vec<Replayer> {
    let replayer = |name, build: Build| {
        let root = root.to_owned();
        Replayer::new(name, move |arguments| build.start(&root, REPLAY, arguments))
    };
    vec![
        replayer("C x86-64", Build::Gcc),
        replayer("C Cortex-M4F", Build::CortexM4F),
        replayer("C Cortex-M0", Build::CortexM0),
    ]
}

/// The static library for this machine, for the Cortex-M4F and for the Cortex-M0.
fn libraries(root: &Path) -> Outcome {
    let targets = Processor::ALL.map(|processor| Some(processor.target()));
    for target in std::iter::once(None).chain(targets) {
        let mut cargo = Command::new("cargo");
        cargo.args(["rustc", "--quiet", "--release", "-p", "narx-ffi", "--lib"]);
        cargo.args(target.map(|target| ["--target", target]).into_iter().flatten());
        // Bare metal has no shared libraries.
        cargo.args(["--crate-type", "staticlib"]).current_dir(root);
        steps::run(&mut cargo)?;
    }
    Ok(Vec::new())
}

/// Builds every program, and has C++ read the header.
fn programs(root: &Path) -> Outcome {
    build::made_directory(root)?;
    for build in Build::ALL {
        for source in CHECKS.into_iter().chain([REPLAY]) {
            build.compile(root, source)?;
        }
    }
    let mut cpp = Command::new("g++");
    cpp.args(["-std=c++17", "-fsyntax-only", "-x", "c++"]).args(STRICT).arg(root.join("ffi/include/narx.h"));
    steps::run(&mut cpp)
}
