//! An emulated microcontroller that runs a program as if it were one of the host's: arguments, files, output and exit code
//! by semihosting.

use crate::install::Package;
use std::path::Path;
use std::process::{Command, Stdio};

/// The emulator; Debian has it in the package of this name.
pub const PROGRAM: &str = "qemu-system-arm";

/// That package.
pub const PACKAGE: Package = Package { name: "qemu-system-arm", provides: PROGRAM };

/// What is emulated. All have flash at 0 and RAM at 2000_0000h.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Machine {
    /// An MPS2 board with image AN386: a Cortex-M4F, 4 MB each, and 16 MB of PSRAM at 2100_0000h.
    Mps2M4,
    /// A BBC micro:bit: a Cortex-M0 with 256 KB of flash and 16 KB of RAM.
    Microbit,
}

impl Machine {
    /// As the emulator calls it.
    const fn name(self) -> &'static str {
        match self {
            Self::Mps2M4 => "mps2-an386",
            Self::Microbit => "microbit",
        }
    }

    /// The linker script of C programs, in `tests/c`.
    pub const fn memory(self) -> &'static str {
        match self {
            Self::Mps2M4 => "mps2.ld",
            Self::Microbit => "microbit.ld",
        }
    }
}

/// A run on a Cortex-M4F of the image `elf` with `arguments` behind its own name. The image opens files of the host by the names that it
/// is given, relative to the directory in which the emulator starts; what it prints is the emulator's standard output.
///
/// The image gets its arguments as one line, split at spaces: an argument with a space or a quote arrives as something
/// else.
pub fn semihosting(elf: &Path, arguments: &[impl AsRef<str>]) -> Command {
    semihosting_on(Machine::Mps2M4, elf, arguments)
}

/// The same on any machine.
pub fn semihosting_on(machine: Machine, elf: &Path, arguments: &[impl AsRef<str>]) -> Command {
    emulator(machine, elf, arguments, "none")
}

/// The same with a TCP server at the image's serial port, port `port` of this machine. The image starts when somebody
/// connects.
pub fn with_serial_port(elf: &Path, arguments: &[impl AsRef<str>], port: &str) -> Command {
    emulator(Machine::Mps2M4, elf, arguments, &format!("tcp:127.0.0.1:{port},server=on,wait=on,nodelay=on"))
}

/// The same, with the file `flash` of 16 MB as the machine's PSRAM: what is written there is in the file when the emulator is gone, however it went.
pub fn with_kept_flash(elf: &Path, port: &str, flash: &str) -> Command {
    let mut command = with_serial_port(elf, &[] as &[&str], port);
    let memory = format!("memory-backend-file,id=flash,size=16M,share=on,mem-path={flash}");
    command.args(["-object", &memory, "-machine", "memory-backend=flash"]);
    command
}

/// A closed run in which one instruction takes exactly 2^7 ns of the machine's time, whatever the host does.
pub fn counting(elf: &Path, arguments: &[impl AsRef<str>]) -> Command {
    let mut command = semihosting(elf, arguments);
    command.args(["-icount", "shift=7,sleep=off"]);
    command
}

fn emulator(machine: Machine, elf: &Path, arguments: &[impl AsRef<str>], serial: &str) -> Command {
    let name = elf.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let mut config = String::from("enable=on,target=native,chardev=semihosting");
    for argument in [name.as_str()].into_iter().chain(arguments.iter().map(AsRef::as_ref)) {
        // In the emulator's options a comma is written twice.
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
