//! Programs that replay recordings: implementations of the control core to be compared.

use super::answer::Answer;
use narx_core::recording::{replay_any, replay_any_until};
use serde::Deserialize;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Something that replays recordings.
pub trait Replay: Sync {
    /// Name of the target, the head of its column in the table.
    fn name(&self) -> &str;
    /// Replays each file, or its first `ticks`; returns an answer or the reason for a failure for each, in
    /// order.
    fn replay(&self, files: &[PathBuf], ticks: Option<u64>) -> Vec<Result<Answer, String>>;
}

/// The core in this process.
#[derive(Clone, Copy, Debug)]
pub struct Native;

impl Replay for Native {
    fn name(&self) -> &'static str {
        "x86-64"
    }

    fn replay(&self, files: &[PathBuf], ticks: Option<u64>) -> Vec<Result<Answer, String>> {
        files.iter().map(|file| native(file, ticks)).collect()
    }
}

fn native(file: &Path, ticks: Option<u64>) -> Result<Answer, String> {
    let bytes = fs::read(file).map_err(|error| error.to_string())?;
    match ticks {
        None => {
            let outcome = replay_any(&bytes).map_err(|error| error.to_string())?;
            let recorded = Some(outcome.recorded_digest);
            Ok(Answer { ticks: outcome.ticks, digest: outcome.digest, recorded, outputs: None })
        }
        Some(ticks) => {
            let prefix = replay_any_until(&bytes, ticks).map_err(|error| error.to_string())?;
            let outputs = prefix.last.map(|outputs| outputs.to_string());
            Ok(Answer { ticks: prefix.ticks, digest: prefix.digest, recorded: None, outputs })
        }
    }
}

/// Number of recordings in one command line: an emulated board has little room for it.
const AT_ONCE: usize = 200;

/// Place of the arguments `[--ticks N] FILE...` in a command.
const ARGUMENTS: &str = "{}";

/// A program of another target.
#[derive(Clone, Debug, Deserialize)]
pub struct Replayer {
    name: String,
    /// Program and arguments, with one [`ARGUMENTS`]. As a word of its own it stands for as many words. At
    /// the end of a word, the text after the last comma is repeated for each argument.
    command: Vec<String>,
}

impl Replayer {
    /// Reads a list of replayers from a JSON file.
    ///
    /// # Errors
    /// Fails if the file cannot be read, or has another content.
    pub fn read(path: &Path) -> Result<Vec<Self>, String> {
        let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        let text = fs::read_to_string(path).map_err(|error| failed(&error))?;
        serde_json::from_str(&text).map_err(|error| failed(&error))
    }

    /// Returns the words of a call with these arguments.
    fn words(&self, arguments: &[String]) -> Vec<String> {
        let mut words = Vec::new();
        for word in &self.command {
            match word.strip_suffix(ARGUMENTS) {
                Some("") => words.extend_from_slice(arguments),
                Some(before) => {
                    let (kept, repeated) = before.split_at(before.rfind(',').unwrap_or(0));
                    // The emulator's options write a comma twice.
                    let each =
                        arguments.iter().map(|argument| repeated.to_owned() + &argument.replace(',', ",,"));
                    words.push(kept.to_owned() + &each.collect::<String>());
                }
                None => words.push(word.clone()),
            }
        }
        words
    }
}

impl Replay for Replayer {
    fn name(&self) -> &str {
        &self.name
    }

    fn replay(&self, files: &[PathBuf], ticks: Option<u64>) -> Vec<Result<Answer, String>> {
        files.chunks(AT_ONCE).flat_map(|files| self.replay_few(files, ticks)).collect()
    }
}

impl Replayer {
    fn replay_few(&self, files: &[PathBuf], ticks: Option<u64>) -> Vec<Result<Answer, String>> {
        let mut arguments: Vec<String> =
            ticks.map(|ticks| vec!["--ticks".into(), ticks.to_string()]).unwrap_or_default();
        arguments.extend(files.iter().map(|file| file.display().to_string()));
        let words = self.words(&arguments);
        let output = Command::new(words.first().map_or("", String::as_str))
            .args(words.iter().skip(1))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .output();
        let output = match output {
            Ok(output) => output,
            Err(error) => return files.iter().map(|_| Err(format!("did not start: {error}"))).collect(),
        };
        let text = String::from_utf8_lossy(&output.stdout);
        // The last line of the error output has the message; the lines before it have the place.
        let complaint = String::from_utf8_lossy(&output.stderr);
        let complaint = complaint.trim().lines().last().unwrap_or_default().to_owned();
        let mut lines = text.lines();
        files
            .iter()
            .map(|file| {
                let line = lines
                    .next()
                    .ok_or_else(|| format!("ended without an answer ({}): {complaint}", output.status))?;
                Answer::parse(&stem(file), line)
            })
            .collect()
    }
}

/// Name of a vector: its file's name without the extension.
pub(super) fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_stand_where_the_command_has_their_place() {
        let words = |command: &[&str]| {
            let command = command.iter().map(|word| (*word).to_owned()).collect();
            let replayer = Replayer { name: String::new(), command };
            replayer.words(&["a".into(), "b,c".into()])
        };
        assert_eq!(words(&["node", "replay.mjs", "{}"]), ["node", "replay.mjs", "a", "b,c"]);
        assert_eq!(
            words(&["qemu", "on,arg=replay,arg={}", "-kernel"]),
            ["qemu", "on,arg=replay,arg=a,arg=b,,c", "-kernel"]
        );
    }
}
