//! Helpers that several suites share.

use std::path::Path;

/// Name of a block of PROTOCOL.md and what makes it.
pub type Block = (&'static str, fn() -> String);

/// PROTOCOL.md as it is.
///
/// # Panics
/// It cannot be read.
pub fn protocol() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../PROTOCOL.md");
    std::fs::read_to_string(path).expect("PROTOCOL.md")
}

/// Compares the blocks of PROTOCOL.md between `generated` marks with what makes them. `UPDATE=1`, set by `cargo xtask generate`, rewrites
/// them.
///
/// # Panics
/// A block is missing or out of date.
pub fn check_blocks(blocks: &[Block]) {
    let text = protocol();
    let mut fresh = text.clone();
    for (name, render) in blocks {
        let open = format!("<!-- generated:{name} -->\n");
        let start = fresh.find(&open).unwrap_or_else(|| panic!("no block {name}")) + open.len();
        let length = fresh[start..].find("<!-- end -->").unwrap_or_else(|| panic!("block {name} has no end"));
        fresh.replace_range(start..start + length, &render());
    }
    if std::env::var_os("UPDATE").is_some() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../PROTOCOL.md");
        // Whole at once: other tests read it meanwhile.
        let beside = path.with_extension("fresh");
        std::fs::write(&beside, &fresh).expect("PROTOCOL.md");
        std::fs::rename(&beside, path).expect("PROTOCOL.md");
        return;
    }
    assert!(text == fresh, "PROTOCOL.md is out of date: cargo xtask generate");
}
