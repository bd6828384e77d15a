//! C programs for the emulated Cortex-M4F.

use crate::install::Package;
use std::path::Path;
use std::process::Command;

/// Compiler and C library.
pub const PACKAGES: [Package; 2] = [
    Package { name: "gcc-arm-none-eabi", provides: COMPILER },
    Package { name: "libnewlib-arm-none-eabi", provides: "/usr/lib/arm-none-eabi/newlib/rdimon.specs" },
];

/// C compilers accept what is ours without a word.
pub const STRICT: [&str; 4] = ["-pedantic", "-Wall", "-Wextra", "-Werror"];

/// The compiler's name.
pub const COMPILER: &str = "arm-none-eabi-gcc";

/// The compiler, with all that makes a program with semihosting of its sources; optimisation is the caller's.
pub fn compiler(root: &Path) -> Command {
    let tests = root.join("tests/c");
    let mut command = Command::new(COMPILER);
    command.args(["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]);
    command.args(["--specs=rdimon.specs", "-Wl,--gc-sections,-z,noexecstack"]);
    command.arg("-T").arg(tests.join("mps2.ld")).arg(tests.join("startup.c"));
    command
}
