//! Results of fuzzing, run by run: fuzz.json. Runs add up as long as the code under test is the same.

use narx_report::figures;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::process::Command;
use std::{fs, io};

/// Files and folders of which the targets consist.
const LOOKED_AT: [&str; 6] = ["Cargo.lock", "core", "boot", "sim", "tests/fuzz/src", "tests/fuzz/Cargo.toml"];

/// Report: everything in one file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Report {
    /// Machine on which rates were measured.
    pub(crate) machine: String,
    /// Targets in the order of their names.
    pub(crate) targets: Vec<Row>,
    /// Sweeps over every identifier, in the order of the tests.
    pub(crate) sweeps: Vec<Sweep>,
}

/// Figures of a target.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Row {
    /// Name of the target.
    pub(crate) target: String,
    /// Time for which it ran, s.
    pub(crate) seconds: u64,
    /// Number of inputs that were run.
    pub(crate) executions: u64,
    /// Number of inputs that reached code that none had reached before.
    pub(crate) new_inputs: u64,
    /// Number of edges that were reached, at the end.
    pub(crate) coverage: u64,
    /// Number of inputs that are kept, at the end.
    pub(crate) corpus: u64,
    /// Broken promises.
    pub(crate) findings: Vec<String>,
    /// Last commit at that time that had changed the code under test.
    pub(crate) commit: String,
}

/// A sweep: every identifier of one length, with every data length code, as data and as remote frame, given
/// to one node.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Sweep {
    /// Node under test.
    pub(crate) node: String,
    /// Length of the identifiers, bits.
    pub(crate) bits: u32,
    /// Number of frames.
    pub(crate) frames: u64,
    /// Duration, s.
    pub(crate) seconds: u64,
    /// Last commit at that time that had changed the code under test.
    pub(crate) commit: String,
}

impl Report {
    /// Reads the present content of the file. Each figure has the commit of its own code, because all
    /// together take hours.
    pub(crate) fn resume(path: &Path) -> Result<Self, String> {
        Ok(Self { machine: figures::machine(), ..Self::read(path)?.unwrap_or_default() })
    }

    /// Reads a file; `None` if there is none.
    pub(crate) fn read(path: &Path) -> Result<Option<Self>, String> {
        let failed = |error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
        match fs::read_to_string(path) {
            Ok(text) => serde_json::from_str(&text).map(Some).map_err(|error| failed(&error)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(failed(&error)),
        }
    }

    /// Adds a run; if the target's row is of other code, replaces it.
    pub(crate) fn add(&mut self, piece: Row) {
        let place = self.targets.binary_search_by(|row| row.target.cmp(&piece.target));
        match place {
            Ok(place) if self.targets[place].commit == piece.commit => self.targets[place].join(&piece),
            Ok(place) => self.targets[place] = piece,
            Err(place) => self.targets.insert(place, piece),
        }
    }

    /// Replaces the older sweep.
    pub(crate) fn put(&mut self, sweep: Sweep) {
        self.sweeps.retain(|old| (&old.node, old.bits) != (&sweep.node, sweep.bits));
        self.sweeps.push(sweep);
        self.sweeps.sort_by(|a, b| (&a.node, a.bits).cmp(&(&b.node, b.bits)));
    }
}

/// Sum of all rows; coverage and corpus of different targets do not add up.
pub(crate) fn total(rows: &[Row]) -> Row {
    let mut all = Row { target: "all".into(), ..Row::default() };
    rows.iter().for_each(|row| all.join(row));
    Row { coverage: 0, ..all }
}

impl Row {
    /// Adds another run of the same target.
    fn join(&mut self, piece: &Self) {
        self.seconds += piece.seconds;
        self.executions += piece.executions;
        self.new_inputs += piece.new_inputs;
        (self.coverage, self.corpus) = (self.coverage.max(piece.coverage), piece.corpus);
        self.findings.extend(piece.findings.iter().cloned());
    }
}

/// Last commit of the code under test, and whether the working copy differs from it.
pub(crate) fn commit(root: &Path) -> Result<String, String> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).arg("--").args(LOOKED_AT).current_dir(root).output();
        let output = output.map_err(|error| format!("git: {error}"))?;
        Ok::<_, String>(String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    let commit = git(&["log", "-1", "--format=%h"])?;
    let changed = !git(&["status", "--porcelain"])?.is_empty();
    Ok(if changed { format!("{commit} with changes") } else { commit })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(target: &str, seconds: u64, executions: u64, findings: &[&str]) -> Row {
        let findings = findings.iter().map(|text| (*text).to_owned()).collect();
        Row {
            target: target.into(),
            seconds,
            executions,
            new_inputs: 1,
            coverage: executions,
            corpus: 7,
            findings,
            commit: "c".into(),
        }
    }

    #[test]
    fn pieces_of_a_target_add_up() {
        let mut report = Report::default();
        let pieces =
            [row("slcan", 60, 500, &[]), row("bus", 30, 900, &["one"]), row("slcan", 10, 40, &["two"])];
        pieces.into_iter().for_each(|piece| report.add(piece));
        let slcan = Row { new_inputs: 2, coverage: 500, ..row("slcan", 70, 540, &["two"]) };
        assert_eq!(report.targets, [row("bus", 30, 900, &["one"]), slcan]);
        let all = total(&report.targets);
        assert_eq!((all.seconds, all.executions, all.new_inputs), (100, 1440, 3));
        assert_eq!(all.findings, ["one", "two"]);
    }

    #[test]
    fn figures_of_other_code_make_room() {
        let path = std::env::temp_dir().join(format!("narx-fuzz-{}.json", std::process::id()));
        let mut report = Report::resume(&path).unwrap();
        assert_eq!(report.targets, []);
        let sweep =
            |frames| Sweep { node: "a drive".into(), bits: 29, frames, seconds: 2, commit: "c".into() };
        report.put(sweep(1));
        report.put(sweep(3));
        assert_eq!(report.sweeps, [sweep(3)]);
        let new = |commit: &str| Row { commit: commit.into(), ..row("bus", 40, 100, &[]) };
        let others = row("slcan", 60, 500, &[]);
        for piece in [new("c"), others.clone(), new("d"), new("d")] {
            report.add(piece);
        }
        let twice = Row { seconds: 80, executions: 200, new_inputs: 2, ..new("d") };
        assert_eq!(report.targets, [twice, others]);
        figures::write(&path, &report).unwrap();
        assert_eq!(Report::resume(&path), Ok(report));
        fs::write(&path, "{}").unwrap();
        assert!(Report::resume(&path).unwrap_err().contains("missing field"));
        fs::remove_file(&path).unwrap();
    }
}
