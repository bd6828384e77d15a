//! The laboratory, for browsers and Node: replay of recordings, logs of a bus, and the drive's blocks one by
//! one. The crate only converts types.
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `recording.rs` | `replay`, `scopeRecording` | [`narx_core::recording`] |
//! | `recording.rs` | `replayTrace` | [`narx_sim::replayed`] |
//! | `can_log.rs` | `readLog` | [`narx_host::can_log`] |
//! | `blocks.rs` | `Pi`, `Ramp`, `Hall`, `Commutation` | [`narx_core::blocks`] |
//! | `zero_crossing.rs` | `ZeroCrossing` | [`narx_core::blocks`] |
#![forbid(unsafe_code)]

mod blocks;
mod can_log;
mod recording;
mod zero_crossing;

pub use blocks::{Commutation, Hall, Pi, Ramp};
pub use can_log::read_log;
pub use recording::{replay, replay_trace, scope_recording};
pub use zero_crossing::ZeroCrossing;
