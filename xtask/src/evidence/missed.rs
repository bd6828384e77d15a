//! Reasons for missed goals: `docs/evidence/missed.toml`. The page is not made if a missed goal has no
//! reason, or if a reason belongs to a goal that is not missed.

use super::FIGURES;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// Reasons by name of the figure that misses its goal.
type Why = BTreeMap<String, String>;

/// Reads the reasons.
fn read(root: &Path) -> Result<Why, String> {
    let path = root.join(FIGURES).join("missed.toml");
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
}

/// Missed figures of one table: collected, then explained.
#[derive(Default)]
pub(super) struct Missed(Vec<String>);

impl Missed {
    /// Notes a figure.
    pub(super) fn add(&mut self, name: &str) {
        if !self.0.iter().any(|known| known == name) {
            self.0.push(name.into());
        }
    }

    /// Returns a line for each missed figure, nothing if there is none. `of` selects the names that belong to
    /// this table.
    pub(super) fn explain(&self, root: &Path, of: impl Fn(&str) -> bool) -> Result<String, String> {
        explain(&self.0, &read(root)?, of)
    }
}

fn explain(missed: &[String], why: &Why, of: impl Fn(&str) -> bool) -> Result<String, String> {
    if let Some(name) = why.keys().find(|name| of(name) && !missed.contains(name)) {
        return Err(format!("{name:?} is explained in {FIGURES}/missed.toml but not missed"));
    }
    let mut text = String::new();
    for name in missed {
        let why = why
            .get(name)
            .ok_or_else(|| format!("{name:?} is missed, and {FIGURES}/missed.toml does not say why"))?;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "* *{name}*: {why}");
    }
    if !text.is_empty() {
        text.insert_str(0, "\nWhat is missed, and why:\n\n");
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missed_is_explained_and_nothing_else() {
        let why =
            [("jitter", "noise"), ("flash", "tables")].map(|(name, why)| (name.to_owned(), why.to_owned()));
        let why = Why::from(why);
        let missed = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        assert_eq!(explain(&[], &Why::new(), |_| true), Ok(String::new()));
        let text = explain(&missed(&["jitter"]), &why, |name| name == "jitter").unwrap();
        assert!(text.ends_with("\n\n* *jitter*: noise\n"), "{text}");
        assert!(explain(&missed(&["angle"]), &why, |_| false).unwrap_err().contains("\"angle\" is missed"));
        assert!(
            explain(&missed(&["jitter"]), &why, |_| true).unwrap_err().contains("\"flash\" is explained")
        );
    }
}
