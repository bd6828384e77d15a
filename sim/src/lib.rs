#![no_std]
//! The bench.
