//! The narx control core.
#![no_std]
#![forbid(unsafe_code)]

pub mod bus;
pub mod dictionary;
pub mod motor;
pub mod node;
pub mod recording;
pub mod units;
