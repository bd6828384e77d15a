//! The drive on the B-G431B-ESC1, alone in the flash: put there by a debugger, with everything that the board
//! has use for.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image;

#[cfg(not(target_os = "none"))]
fn main() {}
