//! What the developer commands are made of.

pub mod candump;
pub mod coverage;
pub mod csv;
pub mod demo;
pub mod header;
pub mod interop;
pub mod plot;
pub mod qemu;
pub mod steps;
pub mod vectors;
