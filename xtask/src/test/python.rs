//! The Python package.

use crate::parity::Replayer;
use crate::steps::Step;
use std::path::Path;

/// What is run, in order.
pub fn steps(_root: &Path) -> Vec<Step<'_>> {
    Vec::new()
}

/// What replays recordings, once [`steps`] have built it.
pub fn replayers(_root: &Path) -> Vec<Replayer> {
    Vec::new()
}
