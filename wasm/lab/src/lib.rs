//! The laboratory: recordings that run again, logs of a bus, and the stations of the drive one by one, in browsers and Node: types are converted and nothing else is done.
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `recording.rs` | `replay`, `replayTrace`, `scopeRecording` | [`narx_core::recording`], [`narx_sim::replayed`] |
//! | `can_log.rs` | `readLog` | [`narx_host::can_log`] |
//! | `blocks.rs`, `zero_crossing.rs` | `Pi`, `Ramp`, `Hall`, `Commutation`, `ZeroCrossing` | [`narx_core::blocks`] |
#![forbid(unsafe_code)]

mod blocks;
mod can_log;
mod recording;
mod zero_crossing;

pub use blocks::{Commutation, Hall, Pi, Ramp};
pub use can_log::read_log;
pub use recording::{replay, replay_trace, scope_recording};
pub use zero_crossing::ZeroCrossing;
