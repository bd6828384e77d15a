//! The repository's sources, searched for items and tests.

use crate::vectors::{self, Scenario};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Text of every Rust file by its path from the root, and the conformance vectors.
#[derive(Debug)]
pub(super) struct Sources {
    files: BTreeMap<String, String>,
    /// Scenarios of the vectors; their texts stand beside them, for the parameters that they name.
    pub(super) vectors: Vec<Scenario>,
    texts: BTreeMap<String, String>,
    /// Texts of the scenarios of nodes.
    transcripts: BTreeMap<String, String>,
}

impl Sources {
    pub(super) fn read(root: &Path) -> Result<Self, String> {
        let mut files = BTreeMap::new();
        for directory in ["core/src", "sim/src", "xtask/src", "firmware/boot", "tests"] {
            collect(root, &root.join(directory), &mut files)?;
        }
        let vectors = vectors::scenarios(root)?;
        let texts = texts_of(&vectors::directory(root), &vectors);
        let transcripts =
            texts_of(&vectors::transcript_directory(root), &vectors::transcript_scenarios(root)?);
        Ok(Self { files, vectors, texts, transcripts })
    }

    /// Returns whether a vector of this name exists, of a drive or of a node.
    pub(super) fn has_vector(&self, name: &str) -> bool {
        self.texts.contains_key(name) || self.transcripts.contains_key(name)
    }

    /// Folder of a vector under `tests`.
    pub(super) fn vector_folder(&self, name: &str) -> &'static str {
        if self.transcripts.contains_key(name) { "vectors/transcripts" } else { "vectors" }
    }

    /// Transcripts that contain an identifier: it is sent by the master, or expected of another node.
    pub(super) fn transcripts_with(&self, identifier: &str) -> Vec<String> {
        let named = self.transcripts.iter().filter(|(_, text)| text.contains(identifier));
        named.map(|(name, _)| name.clone()).collect()
    }

    /// Returns whether `path Item` or `path Type::member` is defined there, or `path number::NAME` used.
    pub(super) fn has_item(&self, reference: &str) -> bool {
        let Some((path, item)) = reference.split_once(' ') else { return false };
        let Some(text) = self.files.get(path) else { return false };
        if item.starts_with("number::") {
            return mentions(text, item);
        }
        item.split("::").all(|name| text.lines().any(|line| defines(line, name)))
    }

    /// Returns whether `suite::name` is a test: in the folder of that name under `tests`, or of a package.
    pub(super) fn has_test(&self, reference: &str) -> bool {
        self.test_file(reference).is_some()
    }

    /// The file of the test `suite::name`.
    pub(super) fn test_file(&self, reference: &str) -> Option<&str> {
        let (suite, name) = reference.split_once("::")?;
        let folder = match suite {
            "xtask" => "xtask/src/".to_owned(),
            "boot" => "firmware/boot/tests/".to_owned(),
            suite => format!("tests/{suite}/"),
        };
        let mut files = self.files.iter().filter(|(path, _)| path.starts_with(&folder));
        let found = files.find(|(_, text)| tests(text).iter().any(|(test, _)| test == name));
        found.map(|(path, _)| path.as_str())
    }

    /// Name of the constant in `number.rs` for a parameter.
    pub(super) fn constant(&self, number: u16) -> Option<&str> {
        let text = self.files.get("core/src/dictionary/number.rs")?;
        let end = format!(": u16 = {number};");
        let line = text
            .lines()
            .find(|line| line.ends_with(&end) && !line.contains("_FIRST") && !line.contains("_LAST"))?;
        line.strip_prefix("pub const ")?.strip_suffix(&end)
    }

    /// Files of the core that read a parameter, except the dictionary's own.
    pub(super) fn users(&self, constant: &str) -> Vec<String> {
        let reference = format!("number::{constant}");
        let core = self
            .files
            .iter()
            .filter(|(path, _)| path.starts_with("core/src/") && !path.starts_with("core/src/dictionary/"));
        core.filter(|(_, text)| mentions(text, &reference)).map(|(path, _)| path.clone()).collect()
    }

    /// Tests that name a parameter. Those of the dictionary's own table show no behaviour and do not count.
    pub(super) fn tests_of(&self, constant: &str) -> Vec<String> {
        let reference = format!("number::{constant}");
        let mut found = Vec::new();
        for (path, text) in self.files.iter().filter(|(path, _)| *path != "tests/protocol/dictionary.rs") {
            let Some(suite) = path.strip_prefix("tests/").and_then(|rest| rest.split('/').next()) else {
                continue;
            };
            // A test that iterates over a table of its file names everything that the table names.
            let tables: Vec<&str> =
                tables(text).filter(|(_, body)| mentions(body, &reference)).map(|t| t.0).collect();
            let named = tests(text).into_iter().filter(|(_, body)| {
                mentions(body, &reference) || tables.iter().any(|table| mentions(body, table))
            });
            found.extend(named.map(|(name, _)| format!("{suite}::{name}")));
        }
        found
    }

    /// Vectors that name a parameter.
    pub(super) fn vectors_of(&self, name: &str) -> Vec<String> {
        let quoted = format!("\"{name}\"");
        self.texts
            .iter()
            .filter(|(_, text)| text.contains(&quoted))
            .map(|(vector, _)| vector.clone())
            .collect()
    }
}

/// Texts of the scenarios in a folder.
fn texts_of(directory: &Path, scenarios: &[Scenario]) -> BTreeMap<String, String> {
    let text = |name: &str| fs::read_to_string(directory.join(format!("{name}.toml"))).unwrap_or_default();
    scenarios.iter().map(|scenario| (scenario.name.clone(), text(&scenario.name))).collect()
}

fn collect(root: &Path, directory: &Path, files: &mut BTreeMap<String, String>) -> Result<(), String> {
    let failed = |error| format!("{}: {error}", directory.display());
    for entry in fs::read_dir(directory).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() {
            collect(root, &path, files)?;
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            files.insert(name, fs::read_to_string(&path).map_err(failed)?);
        }
    }
    Ok(())
}

/// Returns whether a line begins the definition of `name`: an item, a member, a variant or a field.
fn defines(line: &str, name: &str) -> bool {
    let code = line.trim_start();
    if code.starts_with("//") {
        return false;
    }
    let Some(at) = code.match_indices(name).map(|(at, _)| at).find(|at| is_word(code, *at, name.len()))
    else {
        return false;
    };
    let before = code[..at].trim_end();
    let keyword = before.rsplit(' ').next().unwrap_or("");
    let after = code[at + name.len()..].trim_start();
    let item = ["fn", "struct", "enum", "const", "static", "mod", "trait", "type"].contains(&keyword);
    let member = ["", "pub", "pub(super)", "pub(crate)"].contains(&before)
        && ["", ",", "{", "(", ":", "="]
            .iter()
            .any(|sign| after.starts_with(sign) && !after.starts_with("::"))
        && (after.is_empty() || ",{(:=".contains(&after[..1]));
    item || member || code.starts_with("impl")
}

/// Returns whether the text contains `reference` as a whole word.
fn mentions(text: &str, reference: &str) -> bool {
    text.match_indices(reference).any(|(at, _)| is_word(text, at, reference.len()))
}

fn is_word(text: &str, at: usize, length: usize) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    !text[..at].chars().next_back().is_some_and(part) && !text[at + length..].chars().next().is_some_and(part)
}

/// Tests of a file: name and body. A body ends at the closing brace with the indentation of the function's
/// own line.
fn tests(text: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for part in text.split("#[test]").skip(1) {
        let Some((before, rest)) = part.split_once("fn ") else { continue };
        let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let indent = before.rsplit('\n').next().unwrap_or("");
        let end = rest.find(&format!("\n{indent}}}")).unwrap_or(rest.len());
        found.push((name, rest[..end].to_owned()));
    }
    found
}

/// Constants of a file that are tables: name and body.
fn tables(text: &str) -> impl Iterator<Item = (&str, &str)> {
    text.split("\nconst ").skip(1).filter_map(|part| {
        let (name, rest) = part.split_once(": [")?;
        let body = rest.split("\n];").next()?;
        name.chars().all(|c| c.is_uppercase() || c == '_').then_some((name, body))
    })
}

#[cfg(test)]
mod tests_of_the_search {
    use super::*;

    #[test]
    fn definitions_are_told_from_mentions() {
        for (line, name, defined) in [
            ("pub const TRANSITIONS: [T; 3] = [", "TRANSITIONS", true),
            ("    pub(super) fn obey(&mut self) {", "obey", true),
            ("    self.obey(message);", "obey", false),
            ("    TriggerScope,", "TriggerScope", true),
            ("    Command(Command),", "Command", true),
            ("        const OVER_VOLTAGE = 1 << 2;", "OVER_VOLTAGE", true),
            ("    /// fn obey", "obey", false),
            ("impl<S: Sink> Recorder<S> {", "Recorder", true),
            ("    pub speed: u16,", "speed", true),
            ("    let speed = 3;", "speed", false),
            ("    Self::OVER_VOLTAGE", "OVER_VOLTAGE", false),
            ("fn obeyed() {", "obey", false),
        ] {
            assert_eq!(defines(line, name), defined, "{line}");
        }
    }

    #[test]
    fn tests_have_names_and_bodies() {
        let text = "\nconst ROWS: [u16; 1] = [\n    number::C,\n];\n\n#[test]\nfn one() {\n    number::A;\n}\n\nfn helper() {\n    \
                    number::B;\n}\n";
        assert!(
            tables(text).any(|(name, body)| name == "ROWS"
                && body.contains("number::C")
                && !body.contains("number::A"))
        );
        let found = tests(text);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].0, "one");
        assert!(mentions(&found[0].1, "number::A") && !mentions(&found[0].1, "number::B"));
    }
}
