//! The bench in browsers and Node. The crate only converts types of core and bench. The other half of the
//! package, the core without a bench, is `wasm/core`.
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `motor.rs` | `Motor` | [`narx_sim::plant::MotorConfig`], [`narx_sim::presets`] |
//! | `bench.rs` | `Bench`: set-up, runs | [`narx_sim::bench::Bench`] |
//! | `bench.rs` | `Bench`: commands | [`narx_sim::session::Session`] |
//! | `changes.rs` | `Bench`: frames, faults, loads, inputs | [`narx_sim::plant::Plant`] |
//! | `observed.rs` | `Bench`: observation | [`narx_sim::bench::Bench`] |
//!
//! Names are those of Python in camel case. Values are SI units, speeds mechanical rpm.
#![forbid(unsafe_code)]

mod bench;
mod changes;
mod motor;
mod observed;

pub use bench::Bench;
pub use motor::Motor;
