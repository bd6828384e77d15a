//! The virtual drive: `qemu [--motor NAME] [--supply V] [--watchdog MS] [--trouble WHAT] [--after TICKS]`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod drive;
