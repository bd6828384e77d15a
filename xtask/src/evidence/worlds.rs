//! Many faults at once: `cargo xtask worlds`.

use super::{Section, cell, read};
use crate::parity::Counts;
use crate::worlds::Total;
use std::fmt::Write as _;
use std::path::Path;

const COMMAND: &str = "cargo xtask worlds --hours 100 --first 20261122 --out docs/evidence";

const HEAD: &str = "\
A world is a number: from it follow a motor that is off its data sheet, its load and supply, an operator who makes mistakes, parts that break and are mended, a disturbed bus, restarts, power that fails in the middle of a write, and a flash that is gone or blank when it is back. For 20 s they come together at random; what may never happen is looked for in every tick, on the bus, at the bridge and in the \
simulated physics. Then everything is mended, and the drive has to answer, to take its parameters and to turn its motor. A failure prints its number and the commit, and `cargo xtask worlds --world N` tells that world again, event by event. Parameters that another version has stored (STORE_VERSION) cannot come about where there is one version only: `tests/storage/node.rs` has them.

";

/// Section with the invariants, and the conditions under which they were tried.
pub(super) fn section(root: &Path) -> Result<Section, String> {
    let text = match read::<Total>(root, "worlds.json")? {
        Some(total) => table(&total),
        None => format!("Not measured: `{COMMAND}`.\n"),
    };
    Ok(Section { title: "When everything goes wrong at once", text })
}

fn table(total: &Total) -> String {
    let Total { command, commit, worlds, hours, boots, resets, bus_offs, frames, .. } = total;
    let mut text = String::from(HEAD);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "`{command}`, at commit {commit}: {hours:.1} simulated hours in {worlds} worlds, {boots} power-ups, {resets} restarts on request, {bus_offs} times off the bus, {frames} frames.\n"
    );
    let _ = writeln!(text, "| what has to hold | worlds in which it did not |\n|---|---:|");
    for (name, count) in &total.invariants {
        let _ = writeln!(text, "| {} | {count} |", cell(name));
    }
    let _ = writeln!(text, "\n* Mishaps: {}.", list(&total.mishaps));
    let _ = writeln!(text, "* What broke: {}.", list(&total.injections));
    let _ = writeln!(text, "* Worlds with a fault (Table 9): {}.", list(&total.faults));
    let ticks: u64 = total.states.values().sum();
    let shares = total
        .states
        .iter()
        .map(|(name, in_it)| format!("{name} {:.1} %", 100.0 * *in_it as f64 / ticks.max(1) as f64));
    let _ = writeln!(text, "* Time in the states: {}.", shares.collect::<Vec<_>>().join(", "));
    let unable: Vec<String> = total.unable.iter().map(u64::to_string).collect();
    if !unable.is_empty() {
        let _ = writeln!(
            text,
            "* In {} worlds the motor does not turn at the end, and does not in a drive to which nothing has happened either (it, its supply and its set-point do not fit; that is judged elsewhere on this page): {}.",
            unable.len(),
            unable.join(", ")
        );
    } else if total.failures.is_empty() {
        let _ = writeln!(text, "* In every world the motor turns at the end.");
    }
    for (seed, what) in &total.failures {
        let _ = writeln!(text, "* *Failed*: `cargo xtask worlds --world {seed}`, {}.", cell(what));
    }
    text
}

fn list(counts: &Counts) -> String {
    counts.iter().map(|(name, count)| format!("{name} {count}")).collect::<Vec<_>>().join(", ")
}
