//! Disables one row of the specification, for `cargo xtask effects`: the tests that the coverage table names
//! for a row must then fail. No product contains it: without the feature `blind` the compiler answers every
//! query here with false.

/// Returns whether row `row` of `table` has no effect in this process. The environment variable `NARX_BLIND`
/// names it, as in `parameter 13`.
///
/// | table | row | without its effect |
/// |---|---|---|
/// | `parameter` | number | acts as its factory value, and reads as written; the drive's own read as their factory values; a command does nothing |
/// | `transition` | state before times 10, plus state after | never fires |
/// | `cause` | extended fault code | is never raised |
/// | `message` | low 11 bits of the identifier | is not accepted, or not sent |
/// | `object` | index times 256, plus subindex | acts as its factory value |
#[cfg(feature = "blind")]
pub(crate) fn to(table: &str, row: u32) -> bool {
    use std::{env, string::String, sync::OnceLock};
    static CHOSEN: OnceLock<Option<(String, u32)>> = OnceLock::new();
    let chosen = CHOSEN.get_or_init(|| {
        let text = env::var("NARX_BLIND").ok()?;
        let (table, row) = text.split_once(' ')?;
        Some((table.into(), row.parse().ok()?))
    });
    chosen.as_ref().is_some_and(|(its_table, its_row)| *its_row == row && its_table == table)
}

/// Always false in a product.
#[cfg(not(feature = "blind"))]
pub(crate) const fn to(_table: &str, _row: u32) -> bool {
    false
}
