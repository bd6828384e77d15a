//! Helpers that several suites share.

use std::path::Path;

/// Name of a block of PROTOCOL.md, and the function that renders it.
pub type Block = (&'static str, fn() -> String);

/// Text of PROTOCOL.md.
///
/// # Panics
/// Panics if it cannot be read.
pub fn protocol() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../PROTOCOL.md");
    std::fs::read_to_string(path).expect("PROTOCOL.md")
}

/// Compares the blocks of PROTOCOL.md between `generated` marks with the rendered ones. With `UPDATE=1`,
/// which `cargo xtask generate` sets, it rewrites them.
///
/// # Panics
/// Panics if a block is missing or out of date.
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
        // Replaced as a whole: other tests read it meanwhile.
        let beside = path.with_extension("fresh");
        std::fs::write(&beside, &fresh).expect("PROTOCOL.md");
        std::fs::rename(&beside, path).expect("PROTOCOL.md");
        return;
    }
    assert!(text == fresh, "PROTOCOL.md is out of date: cargo xtask generate");
}
