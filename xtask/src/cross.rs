//! C programs for emulated microcontrollers.

use crate::install::Package;
use crate::qemu::Machine;
use std::path::Path;
use std::process::Command;

/// Packages with the compiler and the C library for Arm.
pub(crate) const PACKAGES: [Package; 2] = [
    Package { name: "gcc-arm-none-eabi", provides: "arm-none-eabi-gcc" },
    Package { name: "libnewlib-arm-none-eabi", provides: "/usr/lib/arm-none-eabi/newlib/rdimon.specs" },
];

/// Packages with the compiler and the C library for RISC-V.
pub(crate) const RISCV_PACKAGES: [Package; 2] = [
    Package { name: "gcc-riscv64-unknown-elf", provides: "riscv64-unknown-elf-gcc" },
    Package {
        name: "picolibc-riscv64-unknown-elf",
        provides: "/usr/lib/picolibc/riscv64-unknown-elf/lib/rv32imac/ilp32/libsemihost.a",
    },
];

/// Strict options: C compilers must accept our code without a warning.
pub(crate) const STRICT: [&str; 4] = ["-pedantic", "-Wall", "-Wextra", "-Werror"];

/// Processor for which a program is compiled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Processor {
    /// A Cortex-M4 with floating point, as on the boards.
    CortexM4F,
    /// A Cortex-M0: no floating point, no division, no compare-and-swap.
    CortexM0,
    /// A Cortex-M3, and all above it without floating point.
    CortexM3,
    /// A Cortex-M33 with floating point.
    CortexM33F,
    /// RISC-V, 32 bits: multiplication, atomics and compressed instructions; no floating point.
    Rv32Imac,
}

use Processor::{CortexM0, CortexM3, CortexM4F, CortexM33F, Rv32Imac};

impl Processor {
    /// All processors.
    pub(crate) const ALL: [Self; 5] = [CortexM4F, CortexM0, CortexM3, CortexM33F, Rv32Imac];
    /// Processors whose code is measured: one with all that a control tick can use, and one with the least.
    pub(crate) const MEASURED: [Self; 2] = [CortexM4F, CortexM0];

    /// Rust target of its libraries.
    pub(crate) const fn target(self) -> &'static str {
        match self {
            CortexM4F => "thumbv7em-none-eabihf",
            CortexM0 => "thumbv6m-none-eabi",
            CortexM3 => "thumbv7m-none-eabi",
            CortexM33F => "thumbv8m.main-none-eabihf",
            Rv32Imac => "riscv32imac-unknown-none-elf",
        }
    }

    /// Options that the C compiler needs for it.
    pub(crate) const fn options(self) -> &'static [&'static str] {
        match self {
            CortexM4F => &["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"],
            CortexM0 => &["-mcpu=cortex-m0", "-mthumb", "-mfloat-abi=soft"],
            CortexM3 => &["-mcpu=cortex-m3", "-mthumb", "-mfloat-abi=soft"],
            CortexM33F => &["-mcpu=cortex-m33", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16"],
            Rv32Imac => &["-march=rv32imac", "-mabi=ilp32"],
        }
    }

    /// Options that link its C library for a program that has nothing to do with an emulator.
    pub(crate) const fn library(self) -> &'static str {
        match self {
            CortexM4F | CortexM0 | CortexM3 | CortexM33F => "--specs=nosys.specs",
            Rv32Imac => "--specs=picolibc.specs --oslib=dummyhost",
        }
    }

    /// Name of one of its tools: "gcc", "strip".
    pub(crate) fn tool(self, name: &str) -> String {
        match self {
            CortexM4F | CortexM0 | CortexM3 | CortexM33F => format!("arm-none-eabi-{name}"),
            Rv32Imac => format!("riscv64-unknown-elf-{name}"),
        }
    }

    /// Machine with room for every program that runs its code.
    pub(crate) const fn machine(self) -> Machine {
        match self {
            CortexM4F | CortexM0 | CortexM3 => Machine::Mps2M4,
            CortexM33F => Machine::Mps2M33,
            Rv32Imac => Machine::RiscvVirt,
        }
    }
}

/// Returns the compiler with the options and sources that make a program with semihosting on a Cortex-M4F;
/// the caller chooses the optimisation.
pub(crate) fn compiler(root: &Path) -> Command {
    compiler_for(root, CortexM4F, Machine::Mps2M4)
}

/// Returns the compiler for a processor, with the memory layout of a machine that runs its code.
pub(crate) fn compiler_for(root: &Path, processor: Processor, machine: Machine) -> Command {
    let start = root.join("tests/c/start");
    let mut command = Command::new(processor.tool("gcc"));
    command.args(processor.options()).arg("-Wl,--gc-sections,-z,noexecstack");
    command.arg("-L").arg(&start).arg("-T").arg(start.join(machine.memory())).arg(start.join("start.c"));
    match processor {
        CortexM4F | CortexM0 | CortexM3 | CortexM33F => {
            command.arg("--specs=rdimon.specs").arg(start.join("arm.c"))
        }
        Rv32Imac => command
            .args(["--specs=picolibc.specs", "-nostartfiles", "--oslib=semihost"])
            .arg(start.join("riscv.c")),
    };
    command
}
