//! Board `qemu`: QEMU's machine `mps2-an386`, a Cortex-M4F at 25 MHz with a simulated motor and power stage,
//! and an slcan adapter on UART0.
//!
//! ```text
//!   background: World                                          control interrupt (PendSV)
//!   plant.sample() ─────────── samples, pend ───────────────> Period ─> ControlTick
//!   plant.finish_period() <─── command ───────────────────────────────────┘
//!   UART0 <─> slcan adapter <─> Background                      one period after the other, held back to real time
//! ```

pub mod flash;
pub mod instructions;
pub mod kept;
pub mod pace;
pub mod program;
mod register;
pub mod semihosting;
pub mod slots;
pub mod stack;
pub mod trouble;
pub mod uart;
mod vectors;
pub mod watchdog;
pub mod world;

pub use narx_board::owned::Owned;

use panic_semihosting as _;

/// Clock of the machine, Hz.
pub const CLOCK_HZ: u32 = 25_000_000;
/// The motor on the board, unless another one is asked for.
pub const MOTOR: &str = "bly172s-24v";
/// Bytes of a recording that the images which measure can hold.
pub const RECORDING_MAX: usize = 3 << 20;
/// Bytes of arguments that they take.
pub const ARGUMENTS_MAX: usize = 64 << 10;

/// The name of a recording: its path without directory and `.narxrec`.
pub fn stem(path: &str) -> &str {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.strip_suffix(".narxrec").unwrap_or(name)
}
