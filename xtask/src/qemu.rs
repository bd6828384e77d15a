//! An emulated microcontroller that runs a program as if it were one of the host's: arguments, files, output
//! and exit code go by semihosting.

use crate::install::Package;
use std::path::Path;
use std::process::{Command, Stdio};

/// Name of the emulator; Debian's package has the same name.
pub(crate) const PROGRAM: &str = "qemu-system-arm";

/// Package of the emulator.
pub(crate) const PACKAGE: Package = Package { name: "qemu-system-arm", provides: PROGRAM };

/// An emulated machine. All have flash at 0 and RAM at 2000_0000h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Machine {
    /// An MPS2 board with image AN386: a Cortex-M4F, 4 MB each, and 16 MB of PSRAM at 2100_0000h.
    Mps2M4,
    /// A BBC micro:bit: a Cortex-M0 with 256 KB of flash and 16 KB of RAM.
    Microbit,
}

impl Machine {
    /// Name that the emulator uses.
    const fn name(self) -> &'static str {
        match self {
            Self::Mps2M4 => "mps2-an386",
            Self::Microbit => "microbit",
        }
    }

    /// Linker script of C programs, in `tests/c`.
    pub(crate) const fn memory(self) -> &'static str {
        match self {
            Self::Mps2M4 => "mps2.ld",
            Self::Microbit => "microbit.ld",
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
    let mut command = Command::new(PROGRAM);
    command
        .args(["-machine", machine.name(), "-display", "none", "-monitor", "none", "-serial", serial])
        .args(["-chardev", "stdio,id=semihosting,signal=off", "-semihosting-config", &config])
        .arg("-kernel")
        .arg(elf)
        .stdin(Stdio::null());
    command
}
