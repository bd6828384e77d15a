//! The narx drive as an image for a microcontroller: the boards that need no silicon, and what all boards
//! with a Cortex-M have in common. A board on silicon is a package of its own. What a board implements, and
//! the shell around it, is narx-board's.
#![no_std]

pub mod boards;
