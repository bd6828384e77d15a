//! An emulated microcontroller that runs a program as if it were one of the host's: arguments, files, output
//! and exit code go by semihosting.

use crate::install::Package;
use std::path::Path;
use std::process::{Command, Stdio};

/// Name of the emulator; Debian's package has the same name.
pub(crate) const PROGRAM: &str = "qemu-system-arm";

/// Package of the emulator.
pub(crate) const PACKAGE: Package = Package { name: "qemu-system-arm", provides: PROGRAM };

/// Package of the emulator of RISC-V.
pub(crate) const RISCV_PACKAGE: Package =
    Package { name: "qemu-system-misc", provides: "qemu-system-riscv32" };

/// An emulated machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Machine {
    /// An MPS2 board with image AN386: a Cortex-M4F.
    Mps2M4,
    /// An MPS2 board with image AN505: a Cortex-M33 with floating point.
    Mps2M33,
    /// A BBC micro:bit: a Cortex-M0 with 256 KB of flash and 16 KB of RAM.
    Microbit,
    /// QEMU's own machine for RISC-V.
    RiscvVirt,
}

impl Machine {
    /// The emulator of this machine.
    fn emulator(self) -> Command {
        let (program, arguments): (_, &[&str]) = match self {
            Self::Mps2M4 => (PROGRAM, &["-machine", "mps2-an386"]),
            Self::Mps2M33 => (PROGRAM, &["-machine", "mps2-an505"]),
            Self::Microbit => (PROGRAM, &["-machine", "microbit"]),
            Self::RiscvVirt => (RISCV_PACKAGE.provides, &["-machine", "virt", "-bios", "none"]),
        };
        let mut command = Command::new(program);
        command.args(arguments);
        command
    }

    /// Linker script of C programs, in `tests/c/start`.
    pub(crate) const fn memory(self) -> &'static str {
        match self {
            Self::Mps2M4 => "mps2.ld",
            Self::Mps2M33 => "mps2-m33.ld",
            Self::Microbit => "microbit.ld",
            Self::RiscvVirt => "virt.ld",
        }
    }
}

/// Runs the image `elf` on a Cortex-M4F with `arguments` after its own name. The image opens files of the
/// host by the given names, relative to the directory in which the emulator starts; its output is the
/// emulator's standard output.
///
/// The image gets its arguments as one line, split at spaces: an argument with a space or a quote arrives
/// changed.
pub(crate) fn semihosting(elf: &Path, arguments: &[impl AsRef<str>]) -> Command {
    semihosting_on(Machine::Mps2M4, elf, arguments)
}

/// Runs an image on any machine, as [`semihosting`] does.
pub(crate) fn semihosting_on(machine: Machine, elf: &Path, arguments: &[impl AsRef<str>]) -> Command {
    emulator(machine, elf, arguments, "none")
}

/// Runs an image as [`semihosting`] does, with a TCP server at its serial port: port `port` of this machine.
/// The image starts when a client connects.
pub(crate) fn with_serial_port(elf: &Path, arguments: &[impl AsRef<str>], port: &str) -> Command {
    emulator(Machine::Mps2M4, elf, arguments, &format!("tcp:127.0.0.1:{port},server=on,wait=on,nodelay=on"))
}

/// Runs an image as [`with_serial_port`] does, with the file `flash` of 16 MB as the machine's PSRAM: bytes
/// that are written there stay in the file after the emulator has ended, in whatever way it ended.
pub(crate) fn with_kept_flash(elf: &Path, port: &str, flash: &str) -> Command {
    let mut command = with_serial_port(elf, &[] as &[&str], port);
    let memory = format!("memory-backend-file,id=flash,size=16M,share=on,mem-path={flash}");
    command.args(["-object", &memory, "-machine", "memory-backend=flash"]);
    command
}

/// Runs an image in a closed run in which one instruction takes exactly 2^7 ns of the machine's time,
/// whatever the host does.
pub(crate) fn counting(elf: &Path, arguments: &[impl AsRef<str>]) -> Command {
    let mut command = semihosting(elf, arguments);
    command.args(["-icount", "shift=7,sleep=off"]);
    command
}

fn emulator(machine: Machine, elf: &Path, arguments: &[impl AsRef<str>], serial: &str) -> Command {
    let name = elf.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let mut config = String::from("enable=on,target=native,chardev=semihosting");
    for argument in [name.as_str()].into_iter().chain(arguments.iter().map(AsRef::as_ref)) {
        // The emulator's options write a comma twice.
        config.push_str(",arg=");
        config.push_str(&argument.replace(',', ",,"));
    }
    let mut command = machine.emulator();
    command
        .args(["-display", "none", "-monitor", "none", "-serial", serial])
        .args(["-chardev", "stdio,id=semihosting,signal=off", "-semihosting-config", &config])
        .arg("-kernel")
        .arg(elf)
        .stdin(Stdio::null());
    command
}
