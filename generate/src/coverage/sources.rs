//! The repository's sources, searched for items and tests.

use narx_core::motor::State;
use proc_macro2::{Delimiter, LexError, TokenStream, TokenTree};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs;
use std::path::Path;

/// Items of every Rust file by its path from the root, and the conformance vectors.
#[derive(Debug)]
pub(super) struct Sources {
    files: BTreeMap<String, Vec<Item>>,
    /// Scenarios by their paths from `tests/vectors`, without ending. Those of nodes are in a folder there.
    vectors: BTreeMap<String, Vector>,
}

/// Scenario of a vector, as far as the table needs it.
#[derive(Debug, Deserialize)]
pub(super) struct Vector {
    #[serde(skip)]
    pub(super) text: String,
    pub(super) expect: Expect,
}

/// Results that a scenario expects.
#[derive(Debug, Deserialize)]
pub(super) struct Expect {
    pub(super) states: Vec<State>,
    #[serde(default)]
    pub(super) faults: Vec<String>,
    #[serde(default)]
    pub(super) codes: Vec<u16>,
}

/// Item of a file, at any depth.
#[derive(Debug)]
struct Item {
    /// Its keyword; `test` for a function that is one.
    kind: String,
    name: String,
    /// Tokens behind the name. Comments and texts are none: what they name does not count.
    text: String,
}

/// Keywords of items, each before a name. A file also reads a parameter that it imports.
const KEYWORDS: [&str; 9] = ["const", "enum", "fn", "mod", "static", "struct", "trait", "type", "use"];

impl Sources {
    pub(super) fn read(root: &Path) -> Result<Self, String> {
        let mut texts = BTreeMap::new();
        for directory in ["core/src", "sim/src", "boot", "tests"] {
            collect(root, &root.join(directory), &mut texts)?;
        }
        let (mut files, mut vectors) = (BTreeMap::new(), BTreeMap::new());
        for (path, text) in texts {
            let failed = |error: &dyn Display| format!("{path}: {error}");
            let name = path.strip_prefix("tests/vectors/").and_then(|name| name.strip_suffix(".toml"));
            if let Some(name) = name {
                let vector = toml::from_str(&text).map_err(|error| failed(&error))?;
                vectors.insert(name.to_owned(), Vector { text, ..vector });
            } else if path.ends_with(".rs") {
                files.insert(path.clone(), items(&text).map_err(|error| failed(&error))?);
            }
        }
        Ok(Self { files, vectors })
    }

    /// Path of a vector from `tests/vectors`, without ending.
    pub(super) fn vector(&self, name: &str) -> Option<&str> {
        self.vectors.keys().map(String::as_str).find(|path| last(path) == name)
    }

    /// Names of the vectors of a drive, or of those of nodes, for which `holds` is true.
    pub(super) fn vectors(&self, of_nodes: bool, holds: impl Fn(&Vector) -> bool) -> Vec<String> {
        let chosen =
            self.vectors.iter().filter(|(path, vector)| path.contains('/') == of_nodes && holds(vector));
        chosen.map(|(path, _)| last(path).to_owned()).collect()
    }

    /// Returns whether `path Item` is defined there, `path Type::member` within the braces of the type, or
    /// `path number::NAME` used.
    pub(super) fn has_item(&self, reference: &str) -> bool {
        let Some((path, item)) = reference.split_once(' ') else { return false };
        let mut items = self.files.get(path).into_iter().flatten();
        match item.split_once("::") {
            None => items.any(|found| found.name == item),
            Some(("number", _)) => items.any(|found| found.mentions(item)),
            Some((name, member)) => items.any(|found| found.name == name && found.mentions(member)),
        }
    }

    /// The file of the test `suite::name`: in the folder of that name under `tests`, or of a package.
    pub(super) fn test_file(&self, reference: &str) -> Option<&str> {
        let (suite, name) = reference.split_once("::")?;
        let folder = match suite {
            "boot" => "boot/tests/".to_owned(),
            suite => format!("tests/{suite}/"),
        };
        let mut files = self.files.iter().filter(|(path, _)| path.starts_with(&folder));
        files
            .find(|(_, items)| of("test", items).any(|test| test.name == name))
            .map(|(path, _)| path.as_str())
    }

    /// Name of the constant in `number.rs` for a parameter.
    pub(super) fn constant(&self, number: u16) -> Option<&str> {
        let text = format!(" : u16 = {number} ; ");
        let mut constants = of("const", self.files.get("core/src/dictionary/number.rs")?);
        let is_bound = |name: &str| name.contains("_FIRST") || name.contains("_LAST");
        constants.find(|item| item.text == text && !is_bound(&item.name)).map(|item| item.name.as_str())
    }

    /// Files of the core that read a parameter, except the dictionary's own.
    pub(super) fn users(&self, constant: &str) -> Vec<String> {
        let reference = format!("number::{constant}");
        let reads = self.files.iter().filter(|(path, items)| {
            path.starts_with("core/src/")
                && !path.starts_with("core/src/dictionary/")
                && items.iter().any(|item| item.mentions(&reference))
        });
        reads.map(|(path, _)| path.clone()).collect()
    }

    /// Tests that name a parameter. Those of the dictionary's own table show no behaviour and do not count.
    pub(super) fn tests_of(&self, constant: &str) -> Vec<String> {
        let reference = format!("number::{constant}");
        let mut found = Vec::new();
        for (path, items) in self.files.iter().filter(|(path, _)| *path != "tests/protocol/dictionary.rs") {
            let Some((suite, _)) = path.strip_prefix("tests/").and_then(|rest| rest.split_once('/')) else {
                continue;
            };
            // A test with a table of its file names everything that the table names.
            let mut names = vec![reference.as_str()];
            names.extend(
                of("const", items).filter(|table| table.mentions(&reference)).map(|table| &*table.name),
            );
            let named = of("test", items).filter(|test| names.iter().any(|name| test.mentions(name)));
            found.extend(named.map(|test| format!("{suite}::{}", test.name)));
        }
        found
    }
}

impl Item {
    fn mentions(&self, path: &str) -> bool {
        self.text.contains(&format!(" {} ", path.replace("::", " : : ")))
    }
}

fn of<'a>(kind: &'static str, items: &'a [Item]) -> impl Iterator<Item = &'a Item> {
    items.iter().filter(move |item| item.kind == kind)
}

fn last(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

/// Appends the texts of a folder's Rust and TOML files.
fn collect(root: &Path, directory: &Path, texts: &mut BTreeMap<String, String>) -> Result<(), String> {
    let failed = |error| format!("{}: {error}", directory.display());
    for entry in fs::read_dir(directory).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() {
            collect(root, &path, texts)?;
        } else if path.extension().is_some_and(|ending| ending == "rs" || ending == "toml") {
            let name = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
            texts.insert(name, fs::read_to_string(&path).map_err(failed)?);
        }
    }
    Ok(())
}

fn items(text: &str) -> Result<Vec<Item>, LexError> {
    let mut items = Vec::new();
    find(text.parse()?, &mut items);
    Ok(items)
}

/// Appends the items among these tokens. Those in a macro count, too: it need not be Rust but for them.
fn find(tokens: TokenStream, items: &mut Vec<Item>) {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut is_test = false;
    for (at, token) in tokens.iter().enumerate() {
        if let TokenTree::Group(group) = token {
            is_test |= group.delimiter() == Delimiter::Bracket && group.stream().to_string() == "test";
            find(group.stream(), items);
        }
        let [TokenTree::Ident(keyword), TokenTree::Ident(name), rest @ ..] = &tokens[at..] else { continue };
        let [kind, name] = [keyword, name].map(ToString::to_string);
        if KEYWORDS.contains(&&*kind) && !KEYWORDS.contains(&&*name) {
            let kind = if std::mem::take(&mut is_test) { "test".into() } else { kind };
            let ends = |token: &TokenTree| match token {
                TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
                token => token.to_string() == ";",
            };
            let length = rest.iter().position(ends).map_or(rest.len(), |last| last + 1);
            let text = words(rest[..length].iter().cloned().collect());
            items.push(Item { kind, name, text });
        }
    }
}

/// Names, signs and numbers, each between blanks.
fn words(tokens: TokenStream) -> String {
    tokens.into_iter().fold(" ".into(), |text, token| match token {
        TokenTree::Group(group) => text + words(group.stream()).trim_start(),
        TokenTree::Literal(literal) if literal.to_string().contains('"') => text,
        token => format!("{text}{token} "),
    })
}

#[cfg(test)]
mod tests_of_the_search {
    use super::*;

    const FILE: &str = "
        impl<S: Sink> Recorder<S> { pub(super) fn handle(&mut self) { self.follow(message); let speed = 3; } }
        pub enum ToDrive { TriggerScope, Command(Command) } // enum Comment
        bitflags! { pub struct FaultWord: u32 { const OVER_VOLTAGE = 1 << 2; } }
        const TEXT: &str = \"fn text() {}\";
        const ROWS: [u16; 1] = [number::C];
        proptest! {
            /// Also number::D.
            #[test]
            #[ignore]
            fn one(value in 0..3) { for row in ROWS { number::A; } }
        }
        fn helper() { number::B; }
    ";

    #[test]
    fn items_are_told_from_mentions() {
        let files = BTreeMap::from([("a.rs".to_owned(), items(FILE).unwrap())]);
        let sources = Sources { files, vectors: BTreeMap::new() };
        let there =
            ["handle", "ToDrive::TriggerScope", "ToDrive::Command", "FaultWord::OVER_VOLTAGE", "number::B"];
        let absent = ["follow", "speed", "Comment", "text", "ToDrive::OVER_VOLTAGE", "number::D"];
        for item in there.iter().chain(&absent) {
            assert_eq!(sources.has_item(&format!("a.rs {item}")), there.contains(item), "{item}");
        }
    }

    #[test]
    fn tests_have_names_and_bodies() {
        let items = items(FILE).unwrap();
        let tests: Vec<&Item> = of("test", &items).collect();
        assert_eq!(tests.len(), 1);
        assert_eq!(tests[0].name, "one");
        for (path, named) in [("number::A", true), ("ROWS", true), ("number::B", false), ("number::C", false)]
        {
            assert_eq!(tests[0].mentions(path), named, "{path}");
        }
        assert!(of("const", &items).any(|table| table.name == "ROWS" && table.mentions("number::C")));
    }
}
