//! Committed files that follow from the code, and that the tests compare with it: the CAN database, the EDS,
//! the C header, coefficients for examples in C, the table of coverage, the pictures of the README, and the
//! page of evidence.

#![forbid(unsafe_code)]

pub mod coefficients;
pub mod coverage;
pub mod dbc;
pub mod decoded;
pub mod eds;
pub mod effects;
pub mod evidence;
pub mod header;
pub mod pictures;
pub mod port;
pub mod samples;
pub mod settings;

use narx_report::steps::Outcome;
use std::fs;
use std::path::Path;

/// Files that were made, and a line about them.
pub struct Made {
    /// Names from the root, and contents.
    pub files: Vec<(String, String)>,
    /// Closing line of the command.
    pub summary: String,
}

/// Makes files from the working copy at a root.
pub type Make = fn(&Path) -> Result<Made, String>;

/// Writes the files that have changed or, with `check`, fails with their names and writes nothing.
///
/// # Errors
/// Fails if a file cannot be made or written, or differs.
pub fn settle(root: &Path, make: Make, check: bool) -> Outcome {
    let Made { files, summary } = make(root)?;
    let mut stale = Vec::new();
    for (name, fresh) in &files {
        let path = root.join(name);
        if fs::read_to_string(&path).is_ok_and(|old| old == *fresh) {
            continue;
        }
        if check {
            stale.push(format!("{name} is out of date: cargo xtask generate"));
        } else {
            fs::write(&path, fresh).map_err(|error| format!("{name}: {error}"))?;
        }
    }
    if stale.is_empty() { Ok(vec![summary]) } else { Err(stale.join("\n")) }
}
