//! The boards that run without silicon, and what all boards with a Cortex-M have in common. Each is built for
//! its own target alone: the shell is all that a host sees of this crate.

#[cfg(target_os = "none")]
pub mod cortex_m;
#[cfg(all(target_os = "none", feature = "qemu"))]
pub mod qemu;
