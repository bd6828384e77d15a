//! Tests of the C library: C programs on this machine, also under sanitizers and checkers, and on emulated
//! microcontrollers.

mod build;
mod package;
mod threads;
mod watched;

use crate::cross::Processor::{CortexM0, CortexM3, CortexM4F, CortexM33F, Rv32Imac};
use crate::cross::{self, STRICT};
use crate::install::{self, Package};
use crate::library::{self, BENCH, Released, SMALL};
use crate::programs::GENERATE;
use crate::qemu::{self, Machine};
use crate::replayer::{ARGUMENTS, Replayer};
use crate::sizes;
use build::Build::{self, For, Small};
use narx_report::steps::output;
use narx_report::steps::{self, Outcome, Step};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Debian packages that the tests need.
const PACKAGES: [Package; 14] = [
    Package { name: "gcc", provides: "gcc" },
    Package { name: "g++", provides: "g++" },
    Package { name: "clang", provides: "clang" },
    Package { name: "cmake", provides: "cmake" },
    Package { name: "doxygen", provides: "doxygen" },
    Package { name: "cppcheck", provides: "cppcheck" },
    Package { name: "make", provides: "make" },
    Package { name: "valgrind", provides: "valgrind" },
    cross::PACKAGES[0],
    cross::PACKAGES[1],
    cross::RISCV_PACKAGES[0],
    cross::RISCV_PACKAGES[1],
    qemu::PACKAGE,
    qemu::RISCV_PACKAGE,
];

/// A drive in C: its functions, and every misuse.
const DRIVE: &str = "tests/c/drive.c";
/// Both protocols from both ends.
const PROTOCOL: &str = "tests/c/protocol.c";
/// Limits of the blocks.
const BLOCKS: &str = "tests/c/blocks.c";
/// Flash of a drive.
const STORAGE: &str = "tests/c/storage.c";
/// A drive that spins the simulated motor, commanded by a master.
const SPIN: &str = "tests/c/spin.c";
/// Its drive measures it, and is commissioned from what was measured.
const IDENTIFY: &str = "tests/c/identify.c";
/// The control tick alone turns it.
const SPIN_ALONE: &str = "tests/c/spin_alone.c";
/// Sources of examples for other build systems.
const COPIED: [&str; 4] = [
    "examples/platformio/src/main.c",
    "examples/platformio/src/board.c",
    "examples/zephyr/src/main.c",
    "examples/zephyr/src/board.c",
];
/// Programs that check themselves: the tests, and the examples that are whole programs.
const CHECKS: [&str; 17] = [
    DRIVE,
    PROTOCOL,
    BLOCKS,
    STORAGE,
    "ffi/examples/commutation.c",
    "ffi/examples/fault.c",
    "ffi/examples/flash.c",
    "ffi/examples/hall.c",
    "ffi/examples/master.c",
    "ffi/examples/messages.c",
    "ffi/examples/motor.c",
    "ffi/examples/pi.c",
    "ffi/examples/port.c",
    "ffi/examples/ramp.c",
    "ffi/examples/state.c",
    "ffi/examples/tx_driver.c",
    "ffi/examples/zero_crossing.c",
];
/// Program that replays recordings.
const REPLAY: &str = "tests/c/replay.c";

/// Steps in their order.
pub(crate) fn steps(root: &Path) -> Vec<Step<'_>> {
    vec![
        Step::new("C header", move || GENERATE.run(root, &["header", "--check"])),
        Step::new("C tools", || install::debian(&PACKAGES)),
        Step::new("C documentation", move || doxygen(root, &build::directory(root).join("doxygen"), "")),
        Step::new("C library", move || libraries(root)),
        Step::new("C programs", move || programs(root)),
        Step::new("C on x86-64", move || Ok([run(root, Build::Gcc)?, run(root, Build::Clang)?].concat())),
        Step::new("C shared library", move || Build::run_shared(root, DRIVE)),
        Step::new("C sanitized", move || watched::sanitized(root)),
        Step::new("C valgrind", move || watched::valgrind(root)),
        Step::new("C cppcheck", move || watched::cppcheck(root)),
        Step::new("C threads", move || threads::sanitized(root)),
        Step::new("C halves in Miri", move || threads::interpreted(root)),
        Step::new("C on Cortex-M4F", move || run(root, For(CortexM4F))),
        Step::new("C on Cortex-M0", move || Ok([run(root, For(CortexM0))?, microbit(root)?].concat())),
        Step::new("C on Cortex-M3", move || run(root, For(CortexM3))),
        Step::new("C on Cortex-M33F", move || run(root, For(CortexM33F))),
        Step::new("C on RISC-V", move || run(root, For(Rv32Imac))),
        Step::new("C spins a motor", move || spin(root)),
        Step::new("C package", move || package::consumed(root, &tested())),
        Step::new("C sizes", move || sizes::regenerate(root, true)),
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

/// Programs that replay recordings, once [`steps`] has built them.
pub(crate) fn replayers(root: &Path) -> Vec<Replayer> {
    let replayer = |name, build: Build| Replayer::new(name, &build.start(root, REPLAY, &[ARGUMENTS.into()]));
    vec![
        replayer("C x86-64", Build::Gcc),
        replayer("C Cortex-M4F", For(CortexM4F)),
        replayer("C Cortex-M4F small", Small),
        replayer("C Cortex-M0", For(CortexM0)),
        replayer("C Cortex-M3", For(CortexM3)),
        replayer("C Cortex-M33F", For(CortexM33F)),
        replayer("C RV32IMAC", For(Rv32Imac)),
    ]
}

/// The libraries that are tested: all of a release but most of the small ones, which are the same code.
fn tested() -> Vec<Released> {
    let mut libraries = library::released();
    libraries.retain(|&(library, processor)| library != SMALL || processor == Some(CortexM4F));
    libraries
}

/// Builds the static libraries for this machine and every processor, and one with a simulated motor where
/// there is a floating-point unit to compute it.
fn libraries(root: &Path) -> Outcome {
    tested().iter().try_for_each(|(library, processor)| library.build(root, *processor).map(drop))?;
    BENCH.build(root, None)?;
    BENCH.build(root, Some(CortexM4F))
}

/// Makes the documentation of the headers in the folder `made`, with further settings.
///
/// # Errors
/// An item without documentation, or what Doxygen says.
pub(crate) fn doxygen(root: &Path, made: &Path, further: &str) -> Outcome {
    let settings = root.join("ffi/package/Doxyfile");
    let text = fs::read_to_string(&settings).map_err(|error| format!("{}: {error}", settings.display()))?;
    let settings = build::directory(root).join("Doxyfile");
    for folder in [made, &build::directory(root)] {
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    fs::write(&settings, format!("{text}OUTPUT_DIRECTORY = {}\n{further}", made.display()))
        .map_err(|error| format!("{}: {error}", settings.display()))?;
    steps::run(Command::new("doxygen").arg(&settings).current_dir(root.join("ffi")))
}

/// Runs the blocks' examples on the smallest machine, a real Cortex-M0 with 16 KB of RAM.
fn microbit(root: &Path) -> Outcome {
    let program = build::directory(root).join("microbit");
    // 16 KB of memory have no room for a simulated flash, or for a drive beside its master.
    const LARGE: [&str; 2] = ["ffi/examples/flash.c", "ffi/examples/master.c"];
    let fits = |source: &&str| source.starts_with("ffi/examples") && !LARGE.contains(source);
    for source in CHECKS.into_iter().filter(fits) {
        Build::compile_for_microbit(root, source, &program)?;
        let arguments: [&str; 0] = [];
        steps::run(&mut qemu::semihosting_on(Machine::Microbit, &program, &arguments))?;
    }
    Ok(Vec::new())
}

/// Turns the motor, with hall sensors and without, and checks that exactly the same commands are applied to
/// it on this machine and on the emulated one.
fn spin(root: &Path) -> Outcome {
    let mut closing = Vec::new();
    let sensorless = ["--sensorless".to_owned()];
    for (source, arguments) in
        [(SPIN, &[][..]), (SPIN, &sensorless), (SPIN_ALONE, &[]), (SPIN_ALONE, &sensorless), (IDENTIFY, &[])]
    {
        let run = |build: Build| {
            let text = output(&mut build.start(root, source, arguments))?;
            Ok::<_, String>(text.lines().next().unwrap_or_default().to_owned())
        };
        let (here, there) = (run(Build::Sanitized)?, run(For(CortexM4F))?);
        if here != there {
            return Err(format!("{source}: here {here}, on a Cortex-M4F {there}"));
        }
        closing.push(here);
    }
    Ok(closing)
}

/// Builds every program, compiles the examples that people copy, and the header as C++.
fn programs(root: &Path) -> Outcome {
    build::made_directory(root)?;
    for build in Build::all() {
        for source in CHECKS.into_iter().chain([REPLAY]) {
            build.compile(root, source)?;
        }
    }
    Small.compile(root, REPLAY)?;
    for build in [Build::Sanitized, For(CortexM4F)] {
        build.compile_on_bench(root, &[SPIN, "ffi/examples/drive.c"])?;
        build.compile_on_bench(root, &[SPIN_ALONE])?;
        build.compile_on_bench(root, &[IDENTIFY])?;
    }
    let mut copied = Command::new("gcc");
    copied.args(["-std=c99", "-fsyntax-only"]).args(STRICT);
    for folder in ["ffi/include", "tests/c/zephyr/include"] {
        copied.arg("-I").arg(root.join(folder));
    }
    steps::run(copied.args(COPIED.map(|source| root.join(source))))?;
    let mut cpp = Command::new("g++");
    cpp.args(["-std=c++17", "-fsyntax-only", "-x", "c++"]).args(STRICT).arg(root.join("ffi/include/narx.h"));
    steps::run(&mut cpp)
}
