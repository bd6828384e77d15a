#![no_std]
//! The bench.

pub mod plant;
pub mod presets;
pub mod random;
