//! Programs that replay recordings: implementations of the control core to be compared.

use super::answer::Answer;
use narx_core::recording::{replay_any, replay_any_until};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Something that replays recordings.
pub trait Replay {
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

/// Function that returns a program with its fixed arguments and those of one run.
type Start = dyn Fn(&[String]) -> Command;

/// Number of recordings in one command line: an emulated board has little room for it.
const AT_ONCE: usize = 200;

/// A program of another target.
pub struct Replayer {
    name: &'static str,
    command: Box<Start>,
}

impl Replayer {
    /// Builds a replayer of a program that is started with these arguments: `[--ticks N] FILE...`.
    pub fn new(name: &'static str, command: impl Fn(&[String]) -> Command + 'static) -> Self {
        Self { name, command: Box::new(command) }
    }
}

impl Replay for Replayer {
    fn name(&self) -> &str {
        self.name
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
        let output = (self.command)(&arguments)
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
