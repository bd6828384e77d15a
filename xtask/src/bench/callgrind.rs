//! Part of the table: instructions of a simulated tick on this machine.

use super::{Context, tools};
use crate::callgrind::{Counts, VALGRIND};
use crate::driven;
use narx_report::figures::{Figure, Part};

/// Counts the instructions in both modes.
pub(super) fn part(context: &Context<'_>) -> Part {
    if !cfg!(target_arch = "x86_64") {
        return Part::skipped("counted on x86-64 only");
    }
    if let Err(reason) = tools::debian(context, &[VALGRIND]) {
        return Part::skipped(reason);
    }
    let mut part = Part::default();
    for mode in driven::MODES {
        match Counts::new(context.root, mode) {
            Ok(counts) => part.figures.extend(counts.figures().map(|(name, count)| {
                Figure::new(format!("simulated tick on x86-64, {mode}, {name}"), count, "instructions")
            })),
            Err(reason) => part.failures.push(reason),
        }
    }
    part
}
