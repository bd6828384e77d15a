//! The bench in browsers and Node: the same core and bench, with types converted and nothing else done. The other half of the
//! package, the core without a bench, is `wasm/core`.
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `motor.rs` | `Motor` | [`narx_sim::plant::MotorConfig`], [`narx_sim::presets`] |
//! | `bench.rs` | `Bench`: set up, commanded, run | [`narx_sim::session::Session`], [`narx_sim::bench::Bench`] |
//! | `changes.rs` | `Bench`: frames, faults, loads, inputs | [`narx_sim::plant::Plant`] |
//! | `observed.rs` | `Bench`: what is seen of it | [`narx_sim::bench::Bench`] |
//!
//! Names mirror Python's in camel case. Values are SI units, speeds mechanical rpm.
#![forbid(unsafe_code)]

mod bench;
mod changes;
mod motor;
mod observed;

pub use bench::Bench;
pub use motor::Motor;
