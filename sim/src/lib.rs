#![no_std]
#![forbid(unsafe_code)]
//! The bench.

#[cfg(feature = "alloc")]
extern crate alloc;

pub mod can;
#[cfg(feature = "alloc")]
pub mod recording;
#[cfg(feature = "alloc")]
pub mod trace;
