//! The bench.
#![no_std]
#![forbid(unsafe_code)]

pub mod can;
pub mod commissioning;
pub mod plant;
pub mod random;
