//! The C library: C programs on this machine, also under sanitizers, and on an emulated Cortex-M4F.

use super::rust::EMBEDDED;
use crate::cross::STRICT;
use crate::install::{self, Package, target_directory};
use crate::parity::Replayer;
use crate::steps::{self, Outcome, Step};
use crate::{cross, header, qemu, vectors};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A Cortex-M0, which has no compare-and-swap.
const SMALLEST: &str = "thumbv6m-none-eabi";

/// What the tests need from Debian.
const PACKAGES: [Package; 5] = [
    Package { name: "gcc", provides: "gcc" },
    Package { name: "g++", provides: "g++" },
    cross::PACKAGES[0],
    cross::PACKAGES[1],
    Package { name: "qemu-system-arm", provides: qemu::PROGRAM },
];

/// What is run, in order.
pub fn steps(root: &Path) -> Vec<Step<'_>> {
    vec![
        Step::new("C header", move || header::regenerate(root, true)),
        Step::new("C tools", || install::debian(&PACKAGES)),
        Step::new("C targets", || install::rust_target(EMBEDDED).and(install::rust_target(SMALLEST))),
        Step::new("C library", move || libraries(root)),
        Step::new("C programs", move || programs(root)),
        Step::new("C on x86-64", move || steps::run(&mut Command::new(Host.program(root, "drive")))),
        Step::new("C sanitized", move || {
            sanitized_replay(root)?;
            steps::run(&mut Command::new(Sanitized.program(root, "drive")))
        }),
        Step::new("C on Cortex-M4F", move || {
            let arguments: [&str; 0] = [];
            steps::run(&mut qemu::semihosting(&CortexM4F.program(root, "drive"), &arguments))
        }),
    ]
}

/// What replays recordings, once [`steps`] have built it.
pub fn replayers(root: &Path) -> Vec<Replayer> {
    let (host, image) = (Host.program(root, "replay"), CortexM4F.program(root, "replay"));
    vec![
        Replayer::new("C x86-64", move |arguments| {
            let mut command = Command::new(&host);
            command.args(arguments);
            command
        }),
        Replayer::new("C Cortex-M4F", move |arguments| qemu::semihosting(&image, arguments)),
    ]
}

/// How a C program is built.
#[derive(Clone, Copy)]
enum Build {
    /// For this machine.
    Host,
    /// The same, stopped by the first invalid access or undefined behaviour.
    Sanitized,
    /// For an emulated Cortex-M4F, with the host's files by semihosting.
    CortexM4F,
}

use Build::{CortexM4F, Host, Sanitized};

impl Build {
    /// Where the program stands.
    fn program(self, root: &Path, name: &str) -> PathBuf {
        let kind = match self {
            Host => "x86-64",
            Sanitized => "sanitized",
            CortexM4F => "cortex-m4f",
        };
        directory(root).join(format!("{name}-{kind}"))
    }

    /// Compiler and options.
    fn compiler(self, root: &Path) -> Command {
        let mut command = if let CortexM4F = self { cross::compiler(root) } else { Command::new("gcc") };
        command.args(["-std=c99", "-O2", "-g"]).args(STRICT).arg("-I").arg(root.join("ffi/include"));
        if let Sanitized = self {
            command.args(["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]);
        }
        command
    }

    /// The library and what it needs, after the program's sources.
    fn libraries(self, root: &Path) -> Vec<PathBuf> {
        let release = target_directory(root);
        match self {
            Host | Sanitized => {
                let system = ["-lpthread", "-ldl", "-lm"];
                let library = release.join("release/libnarx.a");
                std::iter::once(library).chain(system.map(PathBuf::from)).collect()
            }
            CortexM4F => vec![release.join(EMBEDDED).join("release/libnarx.a")],
        }
    }
}

/// Where the C programs go.
fn directory(root: &Path) -> PathBuf {
    target_directory(root).join("c")
}

/// The static library for this machine, for the Cortex-M4F and, to see that it can be, for a Cortex-M0.
fn libraries(root: &Path) -> Outcome {
    for target in [None, Some(EMBEDDED), Some(SMALLEST)] {
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
    let directory = directory(root);
    fs::create_dir_all(&directory).map_err(|error| format!("{}: {error}", directory.display()))?;
    for build in [Host, Sanitized, CortexM4F] {
        for name in ["drive", "replay"] {
            let mut compiler = build.compiler(root);
            compiler.arg(root.join("tests/c").join(name).with_extension("c"));
            compiler.args(build.libraries(root)).arg("-o").arg(build.program(root, name));
            steps::run(&mut compiler)?;
        }
    }
    let mut cpp = Command::new("g++");
    cpp.args(["-std=c++17", "-fsyntax-only", "-x", "c++"]).args(STRICT).arg(root.join("ffi/include/narx.h"));
    steps::run(&mut cpp)
}

/// All vectors under the sanitizers; the digests are compared elsewhere.
fn sanitized_replay(root: &Path) -> Outcome {
    let mut replay = Command::new(Sanitized.program(root, "replay"));
    steps::run(replay.args(vectors::recordings(root)?))
}
