//! The start-up certificate: `cargo xtask certificate`.

use super::bench::figures;
use super::missed::Missed;
use super::{FIGURES, Section, cell};
use crate::certificate::{BREAKAWAY_MAX, Certificate};
use std::fmt::Write as _;
use std::path::Path;

const HEAD: &str = "\
Where the sensorless start succeeds, and where it does not any more: grids of inertia, load, supply, temperature, angle and friction around the data sheet of every motor of the market, in both directions, well beyond what is promised. Each drive is commissioned from the data \
sheet and knows nothing of what is other. Temperature is that of winding and magnets: resistance and constants follow copper and NdFeB.

![Starts that succeed, in per cent](evidence/certificate.svg)

";

const BREAKAWAY: &str = "
What decides is what friction and load take of the torque that the rotor lock has on the real motor, `k U / (0.75 R)` at the commissioned level. The start pushes with about the same current, so with about the same torque: what takes more of it cannot be moved, and what takes most of it \
leaves nothing to accelerate with. A hot motor has less of it, because its resistance has grown and its magnets have weakened at the same volts. A rotor that is lighter than its data sheet says is the first to be lost, because it swings further and faster than the lock's and \
the ramp's durations were made for. So half is promised, and the starts end somewhere around all of it. These are the starts of the grids whose other factors are within the promise:

";

/// Section with the figures.
pub(super) fn section(root: &Path) -> Result<Section, String> {
    let path = root.join(FIGURES).join("starts.json");
    let certificate =
        Certificate::read(&path).map_err(|error| format!("{error}: cargo xtask certificate"))?;
    let mut text = String::from(HEAD);
    let mut missed = Missed::default();
    let part = &certificate.part;
    // Writing to a string cannot fail.
    let _ = writeln!(text, "`{}`\n\n| figure | | goal | | of what |\n|---|---:|---|---|---|", part.command);
    figures(&mut text, part, &mut missed);
    text += &missed.explain(root, |name| part.figure(name).is_some())?;
    text += BREAKAWAY;
    let _ = writeln!(
        text,
        "| friction and load, of the lock's torque | starts | succeed | |\n|---|---:|---:|---|"
    );
    let mut from = 0.0;
    // A class without starts has no row.
    for (to, tried, started) in certificate.breakaway.iter().filter(|(_, tried, _)| *tried > 0) {
        let share = 100.0 * *started as f64 / (*tried).max(1) as f64;
        let promise = if *to <= BREAKAWAY_MAX { "promised" } else { "" };
        let _ = writeln!(
            text,
            "| {:.0} to below {:.0} % | {tried} | {share:.1} % | {promise} |",
            100.0 * from,
            100.0 * to
        );
        from = *to;
    }
    text += "\nHow the others end. Every one ends in Standby or in a fault that has a name:\n\n| end | within the promise | beyond it |\n|---|---:|---:|\n";
    for (ending, (within, beyond)) in &certificate.endings {
        let _ = writeln!(text, "| {} | {within} | {beyond} |", cell(ending));
    }
    Ok(Section { title: "Where a start succeeds", text })
}
