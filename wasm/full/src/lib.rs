//! The bench of `wasm` with a complete drive: it also has a log memory, a description of itself, and slots
//! with a bootloader for a new program. The bench's own module leaves them out for its size. The bindings are
//! the same, only the linked features differ.
#![forbid(unsafe_code)]

use narx_sim as _;
pub use narx_wasm::{Bench, Motor};
