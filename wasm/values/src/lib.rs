//! What the two modules share: option objects, errors, CAN frames and traces.
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `frame.rs` | `Frame` | [`narx_core::bus::Frame`] |
//! | `trace.rs` | `Trace` | [`narx_sim::trace::Trace`] |
//! | `options.rs`, `error.rs` | option objects, errors | |
#![forbid(unsafe_code)]

pub mod error;
pub mod frame;
pub mod options;
pub mod trace;
