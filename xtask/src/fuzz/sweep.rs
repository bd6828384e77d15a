//! Sweep of every identifier with every data length code, as data and as remote frame, to both nodes: the
//! tests of `tests/fuzz/tests/identifiers.rs`, including the ignored ones.

use super::report::{self, Report, Sweep};
use narx_report::figures;
use std::path::Path;
use std::process::{Command, Stdio};

const TESTS: [&str; 10] = [
    "test",
    "--release",
    "-p",
    "narx-fuzz",
    "--test",
    "identifiers",
    "--",
    "--include-ignored",
    "--nocapture",
    "--test-threads=1",
];

/// Runs the sweeps, and writes their figures into `file`.
pub(super) fn identifiers(root: &Path, file: &Path) -> Result<(), String> {
    let (mut report, commit) = (Report::resume(file)?, report::commit(root)?);
    let output = Command::new("cargo").args(TESTS).current_dir(root).stderr(Stdio::inherit()).output();
    let output = output.map_err(|error| format!("cargo: {error}"))?;
    let said = String::from_utf8_lossy(&output.stdout);
    print!("{said}");
    if !output.status.success() {
        return Err("a frame is not what PROTOCOL.md says".into());
    }
    let swept: Vec<Sweep> = said.lines().filter_map(|line| sweep(line, &commit)).collect();
    if swept.is_empty() {
        return Err("the tests told no figures".into());
    }
    for sweep in swept {
        report.put(sweep);
    }
    figures::write(file, &report)?;
    println!("commit {commit}, written to {}", file.display());
    Ok(())
}

/// Parses `swept BITS FRAMES SECONDS NODE`, which follows the name of the test.
fn sweep(line: &str, commit: &str) -> Option<Sweep> {
    let mut words = line.split_once("swept ")?.1.splitn(4, ' ');
    Some(Sweep {
        bits: words.next()?.parse().ok()?,
        frames: words.next()?.parse().ok()?,
        seconds: words.next()?.parse().ok()?,
        node: words.next()?.into(),
        commit: commit.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_the_tests_are_figures() {
        let line = "test every_29_bit_identifier_to_the_drive ... swept 29 9663676416 61 a drive";
        let told = Sweep {
            node: "a drive".into(),
            bits: 29,
            frames: 9_663_676_416,
            seconds: 61,
            commit: "c".into(),
        };
        assert_eq!(sweep(line, "c"), Some(told));
        for other in ["ok", "test a_frame_is_swept ... ok", "swept 29 many 61 a drive", ""] {
            assert_eq!(sweep(other, "c"), None, "{other}");
        }
    }
}
