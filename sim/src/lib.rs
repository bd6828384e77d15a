#![no_std]
#![forbid(unsafe_code)]
//! The bench.

pub mod can;
