//! The drive on the B-G431B-ESC1 in the active slot of its bootloader, which takes programs over CAN.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() {}
