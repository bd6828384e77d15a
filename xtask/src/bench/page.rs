//! Sizes of the page's modules, and the processor time of a video frame's share of simulation: the packages
//! are built, and the program `tests/wasm/frame.mjs` runs in Node.

use super::{Context, tools};
use crate::web;
use narx_report::figures::{Figure, Part};
use narx_report::steps;

/// Goals, compressed bytes; `tests/wasm/size.test.mjs` holds the present limits.
const MODULES: [(&str, f64); 3] = [("narx", 153_600.0), ("core", 61_440.0), ("lab", 153_600.0)];
/// Processor time that the simulation of one frame at 60 Hz may take (median), and the duration of the frame,
/// ms.
const MEDIAN: f64 = 0.5;
const FRAME: f64 = 16.7;

/// Builds and measures.
pub(super) fn part(context: &Context<'_>) -> Part {
    if let Err(reason) = tools::node(context) {
        return Part::skipped(reason);
    }
    measure(context).unwrap_or_else(|reason| {
        Part::new(vec![Figure::new("page", f64::NAN, "bytes").at_least(0.0)], vec![reason])
    })
}

fn measure(context: &Context<'_>) -> Result<Part, String> {
    web::package(context.root)?;
    let program = context.root.join("tests/wasm/frame.mjs");
    let text = steps::output(web::node().arg(program))?;
    let figure = |key: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(key)?.trim().parse::<f64>().ok());
        line.ok_or_else(|| format!("no {key} in: {text}"))
    };
    let mut figures = Vec::new();
    for (module, limit) in MODULES {
        let bytes = figure(&format!("{module}.gzip"))?;
        figures.push(
            Figure::new(format!("module {module} of the page, compressed"), bytes, "bytes").at_most(limit),
        );
    }
    for mode in ["hall", "sensorless", "open-loop"] {
        for (rows, kept) in [("", ""), (".rows", ", every tick kept")] {
            for (key, name, goal) in [("median", "median", MEDIAN), ("p99", "99 of 100 within", FRAME)] {
                let name = format!("16.7 ms of motor in WebAssembly, {mode}{kept}, {name}");
                let time = figure(&format!("{mode}{rows}.{key}"))?;
                figures.push(Figure::new(name, time, "ms").at_most(goal).note("processor time"));
            }
        }
    }
    Ok(Part::new(figures, Vec::new()))
}
