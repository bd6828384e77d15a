//! What the developer commands are made of.

pub mod bench;
pub mod callgrind;
pub mod candump;
pub mod commutations;
pub mod coverage;
pub mod cross;
pub mod csv;
pub mod dbc;
pub mod decoded;
pub mod demo;
pub mod driven;
pub mod firmware;
pub mod floor;
pub mod header;
pub mod install;
pub mod instructions;
pub mod interop;
pub mod parity;
pub mod plot;
pub mod qemu;
pub mod running;
pub mod steps;
pub mod test;
pub mod vectors;
pub mod web;
