//! narx in browsers and Node: the same core and bench, with types converted and nothing else done.
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `motor.rs` | `Motor` | [`narx_sim::plant::MotorConfig`], [`narx_sim::presets`] |
//! | `bench.rs` | `Bench` | [`narx_sim::session::Session`] |
//! | `trace.rs` | `Trace` | [`narx_sim::trace::Trace`] |
//! | `recording.rs` | `replay` | [`narx_core::recording`] |
//! | `options.rs`, `error.rs` | option objects, errors | |
//!
//! Names mirror Python's in camel case. Values are SI units, speeds mechanical rpm.
#![forbid(unsafe_code)]

mod bench;
mod error;
mod motor;
mod options;
mod recording;
mod trace;

pub use bench::Bench;
pub use motor::Motor;
pub use recording::replay;
pub use trace::Trace;
