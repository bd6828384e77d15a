//! The boards. Each is built for its own target alone: the shell is all that a host sees of this crate.

#[cfg(target_os = "none")]
pub mod qemu;
