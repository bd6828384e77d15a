//! The bench: the real control core in a simulated world of motor, power stage, supply, load, sensors and CAN
//! bus.
//!
//! Everything but the trace builds without std and without heap, because the emulated board carries it too.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "alloc")]
extern crate alloc;

#[cfg(feature = "alloc")]
pub mod bench;
pub mod can;
#[cfg(feature = "alloc")]
mod chip;
#[cfg(feature = "alloc")]
pub mod commutations;
#[cfg(feature = "alloc")]
pub mod experiment;
#[cfg(feature = "flash")]
pub mod flash;
#[cfg(feature = "update")]
pub mod internal_flash;
pub mod plant;
pub mod presets;
pub mod random;
pub mod random_plant;
#[cfg(feature = "alloc")]
pub mod recording;
#[cfg(feature = "alloc")]
pub mod replayed;
#[cfg(feature = "tx-drivers")]
pub mod sensor;
#[cfg(feature = "alloc")]
pub mod session;
#[cfg(feature = "alloc")]
pub mod trace;
#[cfg(feature = "tx-drivers")]
pub mod tx_driver;
