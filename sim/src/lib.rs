#![no_std]
//! The bench.

pub mod plant;
pub mod random;
