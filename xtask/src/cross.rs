//! C programs for emulated microcontrollers.

use crate::install::Package;
use crate::qemu::Machine;
use std::path::Path;
use std::process::Command;

/// Packages with the compiler and the C library.
pub(crate) const PACKAGES: [Package; 2] = [
    Package { name: "gcc-arm-none-eabi", provides: COMPILER },
    Package { name: "libnewlib-arm-none-eabi", provides: "/usr/lib/arm-none-eabi/newlib/rdimon.specs" },
];

/// Strict options: C compilers must accept our code without a warning.
pub(crate) const STRICT: [&str; 4] = ["-pedantic", "-Wall", "-Wextra", "-Werror"];

/// Program that removes debug information.
pub(crate) const STRIP: &str = "arm-none-eabi-strip";

/// Name of the compiler.
pub(crate) const COMPILER: &str = "arm-none-eabi-gcc";

/// Processor for which a program is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Processor {
    /// A Cortex-M4 with floating point, as on the boards.
    CortexM4F,
    /// A Cortex-M0: no floating point, no division, no compare-and-swap.
    CortexM0,
}

impl Processor {
    /// All processors.
    pub(crate) const ALL: [Self; 2] = [Self::CortexM4F, Self::CortexM0];

    /// Rust target of its libraries.
    pub(crate) const fn target(self) -> &'static str {
        match self {
            Self::CortexM4F => "thumbv7em-none-eabihf",
            Self::CortexM0 => "thumbv6m-none-eabi",
        }
    }

    /// Options that the C compiler needs for it.
    pub(crate) const fn options(self) -> &'static [&'static str] {
        match self {
            Self::CortexM4F => &["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
            Self::CortexM0 => &["-mcpu=cortex-m0", "-mthumb", "-mfloat-abi=soft"],
        }
    }
}

/// Returns the compiler with the options and sources that make a program with semihosting on a Cortex-M4F;
/// the caller chooses the optimisation.
pub(crate) fn compiler(root: &Path) -> Command {
    compiler_for(root, Processor::CortexM4F, Machine::Mps2M4)
}

/// Returns the compiler for a processor, with the memory layout of a machine that runs its code.
pub(crate) fn compiler_for(root: &Path, processor: Processor, machine: Machine) -> Command {
    let tests = root.join("tests/c");
    let mut command = Command::new(COMPILER);
    command.args(processor.options());
    command.args(["--specs=rdimon.specs", "-Wl,--gc-sections,-z,noexecstack"]);
    command.arg("-L").arg(&tests).arg("-T").arg(tests.join(machine.memory())).arg(tests.join("startup.c"));
    command
}
