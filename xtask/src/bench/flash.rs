//! Flash of the C library, whole and by parts, and of the core on a small board.

use super::{Context, tools};
use crate::cross::{self, Processor};
use crate::{qemu, sizes, small};
use narx_report::figures::{Figure, Part};

/// Parts of the library that are in the table; `tests/golden/ffi_sizes.toml` has all of them.
const PARTS: [(&str, &str); 5] = [
    ("pi", "a PI alone"),
    ("hall", "hall sensors alone"),
    ("zero_crossing", "zero crossings alone"),
    ("drive", "a drive"),
    ("whole", "every call"),
];

/// Builds and measures.
pub(super) fn part(context: &Context<'_>) -> Part {
    let [compiler, library] = cross::PACKAGES;
    if let Err(reason) = tools::debian(context, &[compiler, library, qemu::PACKAGE]) {
        return Part::skipped(reason);
    }
    measure(context).unwrap_or_else(|reason| {
        Part::new(vec![Figure::new("flash", f64::NAN, "bytes").at_least(0.0)], vec![reason])
    })
}

fn measure(context: &Context<'_>) -> Result<Part, String> {
    let mut figures = Vec::new();
    let processor = Processor::CortexM4F;
    let table = sizes::measured(context.root, processor)?;
    for (key, name) in PARTS {
        let bytes = |kind| Some(table.get(key)?.get(kind)?.as_integer()? as f64);
        let flash = bytes("flash").ok_or_else(|| format!("no flash of {key}"))?;
        figures.push(
            Figure::new(format!("flash of the C library, {name}"), flash, "bytes")
                .note("Cortex-M4F, opt-level 3"),
        );
        if let Some(ram) = bytes("ram").filter(|ram| *ram > 0.0) {
            figures.push(Figure::new(format!("RAM of the C library, {name}"), ram, "bytes"));
        }
    }
    let (least, every) = small::least_and_every(context.root)?;
    figures.push(
        Figure::new("flash of the core on a small board, no features", least as f64, "bytes")
            .note("opt-level z"),
    );
    figures.push(
        Figure::new("flash of the core on a small board, every feature", every as f64, "bytes")
            .note("opt-level z"),
    );
    Ok(Part::new(figures, Vec::new()))
}
