//! The bench of `wasm` whose drive has all that the bench's module leaves out for its size: a log memory, its description of itself, and slots with a
//! bootloader for a new program. The same bindings; only what they are linked with differs.
#![forbid(unsafe_code)]

use narx_sim as _;
pub use narx_wasm::{Bench, Motor};
