//! C programs for emulated microcontrollers.

use crate::install::Package;
use crate::qemu::Machine;
use std::path::Path;
use std::process::Command;

/// Compiler and C library.
pub const PACKAGES: [Package; 2] = [
    Package { name: "gcc-arm-none-eabi", provides: COMPILER },
    Package { name: "libnewlib-arm-none-eabi", provides: "/usr/lib/arm-none-eabi/newlib/rdimon.specs" },
];

/// C compilers accept what is ours without a word.
pub const STRICT: [&str; 4] = ["-pedantic", "-Wall", "-Wextra", "-Werror"];

/// Leaves out what only a debugger reads.
pub const STRIP: &str = "arm-none-eabi-strip";

/// The compiler's name.
pub const COMPILER: &str = "arm-none-eabi-gcc";

/// What a program is compiled for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Processor {
    /// A Cortex-M4 with floating point, as on the boards.
    CortexM4F,
    /// A Cortex-M0: no floating point, no division, no compare-and-swap.
    CortexM0,
}

impl Processor {
    /// Every one.
    pub const ALL: [Self; 2] = [Self::CortexM4F, Self::CortexM0];

    /// The Rust target of its libraries.
    pub const fn target(self) -> &'static str {
        match self {
            Self::CortexM4F => "thumbv7em-none-eabihf",
            Self::CortexM0 => "thumbv6m-none-eabi",
        }
    }

    /// What the C compiler must be told.
    pub const fn options(self) -> &'static [&'static str] {
        match self {
            Self::CortexM4F => &["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
            Self::CortexM0 => &["-mcpu=cortex-m0", "-mthumb", "-mfloat-abi=soft"],
        }
    }
}

/// The compiler, with all that makes a program with semihosting on a Cortex-M4F of its sources; optimisation is the caller's.
pub fn compiler(root: &Path) -> Command {
    compiler_for(root, Processor::CortexM4F, Machine::Mps2M4)
}

/// The same for a processor, in the memory of a machine that runs its code.
pub fn compiler_for(root: &Path, processor: Processor, machine: Machine) -> Command {
    let tests = root.join("tests/c");
    let mut command = Command::new(COMPILER);
    command.args(processor.options());
    command.args(["--specs=rdimon.specs", "-Wl,--gc-sections,-z,noexecstack"]);
    command.arg("-L").arg(&tests).arg("-T").arg(tests.join(machine.memory())).arg(tests.join("startup.c"));
    command
}
