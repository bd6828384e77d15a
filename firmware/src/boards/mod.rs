//! The boards that run without silicon. Each is built for its own target alone: the shell is all that a host sees of this crate.

#[cfg(all(target_os = "none", feature = "qemu"))]
pub mod qemu;
