//! Parts that the modules share: option objects, errors, CAN frames and traces.
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `frame.rs` | `Frame` | [`narx_core::bus::Frame`] |
//! | `trace.rs` | `Trace` | [`narx_sim::trace::Trace`] |
//! | `replay.rs` | `Replay` | [`narx_core::recording::Outcome`] |
//! | `options.rs`, `error.rs` | option objects, errors | |
#![forbid(unsafe_code)]

#[cfg(target_family = "wasm")]
use lol_alloc::{FreeListAllocator, LockedAllocator};

/// Allocator of every module.
#[cfg(target_family = "wasm")]
#[global_allocator]
static ALLOCATOR: LockedAllocator<FreeListAllocator> = LockedAllocator::new(FreeListAllocator::new());

pub mod error;
pub mod frame;
pub mod options;
pub mod replay;
#[cfg(feature = "trace")]
pub mod trace;
