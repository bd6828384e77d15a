//! Equality of the bits on every target: `cargo xtask conformance`.

use super::{Section, read};
use crate::parity::{Conformance, Counts};
use narx_core::motor::State;
use std::fmt::Write as _;
use std::path::Path;

const COMMAND: &str = "cargo xtask conformance --out docs/evidence";

const HEAD: &str = "\
A recording holds what a drive was given in every tick, and a digest of everything that it answered. Each target replays it with its own build of the core, and its digest must be the recorded one; where it is not, the first tick and the first output that differ are named. *Vectors* are the committed \
scenarios of `tests/vectors`; those *of both nodes*, in `tests/vectors/transcripts`, hold what the drive's node and a TX-Driver were told and asked, frame by frame, and their ticks are calls. *Windows of worlds* are 50 ms each around something that goes wrong, from seeded worlds that nobody has chosen, and *one life* is a single recording from power-up on. The Cortex-M targets are emulated, with the code of that processor. `cargo xtask test` makes and replays all of it again on every run.

";

/// Section with the table, and the states, transitions, faults and events in its recordings.
pub(super) fn section(root: &Path) -> Result<Section, String> {
    let text = match read::<Conformance>(root, "conformance.json")? {
        Some(conformance) => table(&conformance),
        None => format!("Not measured: `{COMMAND}`.\n"),
    };
    Ok(Section { title: "The same bits", text })
}

fn table(conformance: &Conformance) -> String {
    let Conformance { command, commit, targets, sets, covered } = conformance;
    let mut text = String::from(HEAD);
    // Writing to a string cannot fail.
    let _ = writeln!(text, "`{command}`, at commit {commit}: {} digests are equal.\n", conformance.digests());
    let _ = writeln!(text, "| digests equal of | recordings | ticks | {} |", targets.join(" | "));
    let _ = writeln!(text, "|---|---:|---:|{}", "---:|".repeat(targets.len()));
    for set in sets {
        let equal: Vec<String> = set.equal.iter().map(u64::to_string).collect();
        let _ =
            writeln!(text, "| {} | {} | {} | {} |", set.name, set.recordings, set.ticks, equal.join(" | "));
    }
    let _ = writeln!(
        text,
        "\nWhat the {} ticks of drives lead the drive through:\n\n| state | ticks |\n|---|---:|",
        covered.ticks
    );
    for state in State::ALL {
        let _ = writeln!(text, "| {} | {} |", state.name(), covered.states.get(state.name()).unwrap_or(&0));
    }
    let _ = writeln!(text, "\n* Transitions (Table 7), times taken: {}.", list(&covered.transitions));
    let _ = writeln!(text, "* Faults (Table 9), recordings with it: {}.", list(&covered.faults));
    let _ = writeln!(text, "* Events: {}.", list(&covered.events));
    let never: Vec<&str> = [&covered.states, &covered.transitions, &covered.faults, &covered.events]
        .into_iter()
        .flatten()
        .filter(|(_, count)| **count == 0)
        .map(|(name, _)| name.as_str())
        .collect();
    let never = if never.is_empty() { "nothing".to_owned() } else { never.join(", ") };
    let _ = writeln!(
        text,
        "* Reached by none of them: {never}. `tests/coverage.md` names tests and vectors of every row of the specification and of every message of both protocols (`cargo xtask coverage`)."
    );
    text
}

/// Lists the items that occur, with their counts.
fn list(counts: &Counts) -> String {
    let there = counts.iter().filter(|(_, count)| **count > 0);
    there.map(|(name, count)| format!("{name} {count}")).collect::<Vec<_>>().join(", ")
}
