//! Recordings that run again and logs of a bus, in browsers and Node: types are converted and nothing else is done.
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `recording.rs` | `replay`, `replayTrace`, `scopeRecording` | [`narx_core::recording`], [`narx_sim::replayed`] |
//! | `can_log.rs` | `readLog` | [`narx_host::can_log`] |
#![forbid(unsafe_code)]

mod can_log;
mod recording;

pub use can_log::read_log;
pub use recording::{replay, replay_trace, scope_recording};
