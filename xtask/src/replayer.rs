//! Programs that replay recordings on a target, as narx-lab calls them.

use serde::Serialize;
use std::process::Command;

/// Place of a replayer's arguments, `[--ticks N] FILE...`, in its command: see `narx_lab::conformance`.
pub(crate) const ARGUMENTS: &str = "{}";

/// A program that replays recordings on a target.
#[derive(Serialize)]
pub(crate) struct Replayer {
    name: &'static str,
    command: Vec<String>,
}

impl Replayer {
    /// Builds a replayer of a command with [`ARGUMENTS`] in it.
    pub(crate) fn new(name: &'static str, command: &Command) -> Self {
        let words = std::iter::once(command.get_program()).chain(command.get_args());
        Self { name, command: words.map(|word| word.to_string_lossy().into_owned()).collect() }
    }
}
