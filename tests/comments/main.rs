//! The form of comments: their width, and the first word of a doc comment.

use std::fs;
use std::path::{Path, PathBuf};

/// Rooms of the workspace that hold Rust code.
const ROOMS: [&str; 15] = [
    "core", "board", "boot", "sim", "lab", "ffi", "python", "wasm", "firmware", "terminal", "generate",
    "report", "xtask", "tests", "examples",
];
/// Largest width of a line that is a comment: that of the code (`rustfmt.toml`).
const WIDTH: usize = 110;
/// First words that begin a riddle. A doc comment begins with a noun phrase or a third-person verb.
const RIDDLES: [&str; 9] = ["What", "Who", "How", "So", "The same", "Where", "Whether", "Why", "When"];

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Appends the Rust files of a folder, those that are built or downloaded excepted.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            if !["target", "node_modules", "pkg", "dist", "corpus"].contains(&name.as_str()) {
                collect(&path, files);
            }
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// The text of a line that is a doc comment.
fn doc(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix("///").or_else(|| line.strip_prefix("//!")).map(str::trim_start)
}

fn begins_with(text: &str, words: &str) -> bool {
    text.strip_prefix(words).is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_'))
}

/// The complaints about one file, a line each.
fn complaints(name: &str, text: &str) -> Vec<String> {
    let (mut found, mut before, mut is_code) = (Vec::new(), false, false);
    for (index, line) in text.lines().enumerate() {
        let doc = doc(line);
        is_code = match doc {
            Some(doc) => is_code ^ doc.starts_with("```"),
            None => false,
        };
        // A row of a table is one line.
        let is_text =
            line.trim_start().starts_with("//") && !is_code && !doc.is_some_and(|doc| doc.starts_with('|'));
        if is_text && line.chars().count() > WIDTH && !line.contains("://") {
            found.push(format!("{name}:{}: wider than {WIDTH}", index + 1));
        }
        if let Some(doc) = doc.filter(|_| !before)
            && let Some(word) = RIDDLES.iter().find(|word| begins_with(doc, word))
        {
            found.push(format!("{name}:{}: begins with \"{word}\"", index + 1));
        }
        before = doc.is_some();
    }
    found
}

#[test]
fn comments_fit_the_width_and_begin_with_what_they_name() {
    let mut files = Vec::new();
    for room in ROOMS {
        collect(&root().join(room), &mut files);
    }
    assert!(files.len() > 300, "{} files", files.len());
    let mut found = Vec::new();
    for path in &files {
        let name = path.strip_prefix(root()).unwrap().to_string_lossy().into_owned();
        found.extend(complaints(&name, &fs::read_to_string(path).unwrap()));
    }
    found.sort();
    assert!(found.is_empty(), "{} comments:\n{}", found.len(), found.join("\n"));
}

#[test]
fn a_riddle_and_a_wide_line_are_found() {
    let wide = format!("// {}", "word ".repeat(30));
    let text = format!("/// What it is.\n/// How is fine here.\nfn f() {{}}\n{wide}\n/// Whole ticks.\n");
    let found = complaints("a.rs", &text);
    assert_eq!(found, ["a.rs:1: begins with \"What\"", "a.rs:4: wider than 110"]);
}
