//! `docs/run-light.svg` and `docs/run-dark.svg`: the picture of a run in the README.

use crate::steps::Outcome;
use crate::{demo, plot};
use std::path::Path;

/// Writes both pictures, or with `check` compares them: the closing line.
///
/// # Errors
/// One cannot be drawn or written, or differs.
pub fn regenerate(root: &Path, check: bool) -> Outcome {
    let light = demo::picture(&[])?;
    let pictures = [("docs/run-dark.svg", plot::dark(&light)), ("docs/run-light.svg", light)];
    for (name, fresh) in &pictures {
        let same = std::fs::read_to_string(root.join(name)).is_ok_and(|old| old == *fresh);
        if check && !same {
            return Err(format!("{name} is out of date: cargo xtask generate"));
        }
        if !same {
            std::fs::write(root.join(name), fresh).map_err(|error| format!("{name}: {error}"))?;
        }
    }
    Ok(vec![format!("2 pictures of {} bytes", pictures[0].1.len())])
}
