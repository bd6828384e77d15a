//! The bench.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "alloc")]
extern crate alloc;

pub mod can;
pub mod commissioning;
pub mod plant;
pub mod random;
#[cfg(feature = "alloc")]
pub mod recording;
#[cfg(feature = "alloc")]
pub mod trace;
