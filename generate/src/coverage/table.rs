//! Rows, as `tests/coverage.toml` gives them and as the code completes them.

use super::sources::Sources;
use serde::Deserialize;

/// Content of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Table {
    /// Sections in the order of the document.
    pub(super) section: Vec<Section>,
}

/// A table of the specification.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Section {
    pub(super) title: String,
    /// Text under the title: a line or two.
    #[serde(default)]
    pub(super) about: String,
    /// Source in the code that lists the rows.
    #[serde(default)]
    pub(super) facts: Facts,
    /// Code and tests of every row.
    #[serde(default)]
    pub(super) code: Vec<String>,
    #[serde(default)]
    pub(super) tests: Vec<String>,
    #[serde(default)]
    pub(super) rows: Vec<Row>,
}

/// Source in the code that lists the rows of a section.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Facts {
    /// None: the file has all rows.
    #[default]
    None,
    /// Table 7.
    Transitions,
    /// Table 9.
    Faults,
    /// Figure 14.
    Messages,
    /// Table 10: the rows of the file add to those of the dictionary.
    General,
    /// Table 11: likewise.
    Control,
    /// Our own parameters: likewise.
    Own,
    /// Table 4 of eddyCAN.
    Objects,
}

/// A row of a section.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Row {
    pub(super) key: String,
    #[serde(default)]
    pub(super) says: String,
    #[serde(default)]
    pub(super) code: Vec<String>,
    #[serde(default)]
    pub(super) tests: Vec<String>,
    #[serde(default)]
    pub(super) vectors: Vec<String>,
    /// Reason why the row has no effect that a test could miss.
    #[serde(default)]
    pub(super) stays: String,
    /// Tests that name the row's item. Those that notice its effect count.
    #[serde(skip)]
    pub(super) mentions: Vec<String>,
}

impl Section {
    /// Checks that everything that is named exists, and that every row has evidence.
    pub(super) fn check(&self, sources: &Sources, wrong: &mut Vec<String>) {
        for row in &self.rows {
            let mut miss =
                |what: String| wrong.push(format!("coverage, {}, row {}: {what}", self.title, row.key));
            for item in &row.code {
                if !sources.has_item(item) {
                    miss(format!("no such code item: {item}"));
                }
            }
            for test in &row.tests {
                if sources.test_file(test).is_none() {
                    miss(format!("no such test: {test}"));
                }
            }
            for vector in &row.vectors {
                if sources.vector(vector).is_none() {
                    miss(format!("no such vector: {vector}"));
                }
            }
            if row.code.is_empty() || row.tests.is_empty() && row.vectors.is_empty() {
                miss("has no code with a test or a vector".into());
            }
        }
    }
}
