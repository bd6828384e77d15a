//! The virtual drive in the slot of a bootloader, from which it can be updated over its bus. It takes the
//! arguments of `qemu`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod drive;
