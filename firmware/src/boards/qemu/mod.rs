//! Board `qemu`: QEMU's machine `mps2-an386`, a Cortex-M4F at 25 MHz.

pub mod instructions;
pub mod semihosting;

use panic_semihosting as _;

/// Bytes of a recording that the images can hold.
pub const RECORDING_MAX: usize = 2 << 20;
/// Bytes of arguments that they take.
pub const ARGUMENTS_MAX: usize = 64 << 10;

/// The name of a recording: its path without directory and `.narxrec`.
pub fn stem(path: &str) -> &str {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.strip_suffix(".narxrec").unwrap_or(name)
}
