//! `docs/run-light.svg` and `docs/run-dark.svg`: the picture of a run in the README.

use crate::Made;
use narx_terminal::{demo, plot};
use std::path::Path;

/// Draws both pictures.
///
/// # Errors
/// Fails if the run cannot be drawn.
pub fn make(_: &Path) -> Result<Made, String> {
    let light = demo::picture(&[])?;
    let summary = format!("2 pictures of {} bytes", light.len());
    let dark = plot::dark(&light);
    Ok(Made {
        files: vec![("docs/run-light.svg".into(), light), ("docs/run-dark.svg".into(), dark)],
        summary,
    })
}
