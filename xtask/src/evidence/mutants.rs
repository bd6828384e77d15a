//! Mutation testing: `cargo xtask mutants`, and the reasons why some mutants survive
//! (`docs/evidence/survivors.toml`).

use super::{FIGURES, Section, cell};
use crate::mutants::{Mutant, Report, areas};
use serde::Deserialize;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const HEAD: &str = "\
Each mutant is one change of the code: a comparison that is turned, a function that answers something else, a term that is missing. A mutant that no test notices is a promise that nobody checks, or a change that alters nothing that can be seen. The latter are \
explained here; without an explanation a survivor is open. Each is run against the tests that are about its area (`xtask/src/mutants/areas.rs`).

`cargo xtask mutants --out docs/evidence`

";

/// Content of the file of survivors.
#[derive(Deserialize)]
struct Survivors {
    #[serde(default)]
    survivor: Vec<Survivor>,
}

/// A survivor, or several that have the same name.
#[derive(Clone, Deserialize)]
struct Survivor {
    #[serde(flatten)]
    mutant: Mutant,
    /// Number of such places in the function.
    #[serde(default = "one")]
    times: usize,
    reason: String,
}

const fn one() -> usize {
    1
}

/// Section with the figures.
pub(super) fn section(root: &Path) -> Result<Section, String> {
    let folder = root.join(FIGURES);
    let report = Report::read(&folder.join("mutants.json"))
        .map_err(|error| format!("{error}: cargo xtask mutants --out {FIGURES}"))?;
    let path = folder.join("survivors.toml");
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let known: Survivors = toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(Section { title: "What the tests notice", text: render(&report, &known.survivor)? })
}

fn render(report: &Report, known: &[Survivor]) -> Result<String, String> {
    let missed: Vec<&Mutant> = report.areas.iter().flat_map(|row| &row.missed).collect();
    for Survivor { mutant, times, .. } in known {
        let live = missed.iter().filter(|missed| **missed == mutant).count();
        if live != *times {
            return Err(format!(
                "{mutant}: explained {times} times in {FIGURES}/survivors.toml, but {live} survive"
            ));
        }
    }
    let reason = |mutant: &Mutant| known.iter().find(|it| it.mutant == *mutant).map(|it| it.reason.as_str());
    let mut text = String::from(HEAD);
    // Writing to a string cannot fail.
    let _ = writeln!(
        text,
        "| area | mutants | run | caught | hung | do not build | explained | open |\n|---|---:|---:|---:|---:|---:|---:|---:|"
    );
    for row in &report.areas {
        let open = row.missed.iter().filter(|mutant| reason(mutant).is_none()).count();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} | {} | {open} |",
            cell(&row.what),
            row.mutants,
            row.run,
            row.caught,
            row.timeout,
            row.unviable,
            row.missed.len() - open
        );
    }
    for (_, what) in areas().into_iter().filter(|(name, _)| report.areas.iter().all(|row| row.area != *name))
    {
        let _ = writeln!(text, "| {} | | not run | | | | | |", cell(what));
    }
    list(&mut text, "Open", missed.iter().filter(|it| reason(it).is_none()).map(|it| (**it).clone()), |_| "");
    let explained = known.iter().map(|it| it.mutant.clone());
    list(&mut text, "Survivors that alter nothing that can be seen", explained, |it| {
        reason(it).unwrap_or("")
    });
    Ok(text)
}

fn list<'a>(
    text: &mut String,
    title: &str,
    mutants: impl Iterator<Item = Mutant>,
    reason: impl Fn(&Mutant) -> &'a str,
) {
    let mut mutants = mutants.peekable();
    if mutants.peek().is_none() {
        return;
    }
    let _ = writeln!(text, "\n{title}:\n");
    for mutant in mutants {
        let why = match reason(&mutant) {
            "" => String::new(),
            why => format!(": {why}"),
        };
        let Mutant { file, function, mutation } = &mutant;
        let place = if function.is_empty() { "a constant" } else { function };
        let _ = writeln!(text, "* `{file}`, `{place}`, *{}*{why}", mutation.replace('*', "\\*"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mutants::Row;

    fn mutant(function: &str) -> Mutant {
        Mutant { file: "a.rs".into(), function: function.into(), mutation: "replace < with <=".into() }
    }

    fn report(missed: &[&str]) -> Report {
        let missed = missed.iter().map(|function| mutant(function)).collect();
        let (area, what) = ("boot".into(), "the boot".into());
        let row = Row { area, what, mutants: 9, run: 8, caught: 4, timeout: 1, unviable: 1, missed };
        Report { areas: vec![row] }
    }

    fn known(function: &str, times: usize) -> Survivor {
        Survivor { mutant: mutant(function), times, reason: "equal".into() }
    }

    #[test]
    fn a_survivor_is_open_or_explained() {
        let text = render(&report(&["f", "g"]), &[known("g", 1)]).unwrap();
        assert!(text.contains("| the boot | 9 | 8 | 4 | 1 | 1 | 1 | 1 |\n"), "{text}");
        assert!(text.contains("| messages of eddyCAN | | not run |"), "{text}");
        assert!(text.contains("\nOpen:\n\n* `a.rs`, `f`, *replace < with <=*\n\nSurvivors"), "{text}");
        assert!(text.ends_with(":\n\n* `a.rs`, `g`, *replace < with <=*: equal\n"), "{text}");
    }

    /// An explanation applies to all mutants of a name, or to none.
    #[test]
    fn a_reason_without_its_survivors_is_an_error() {
        for (missed, times) in [(&["f"][..], 1), (&["g", "g"], 1), (&["g"], 2)] {
            let error = render(&report(missed), &[known("g", times)]).unwrap_err();
            assert!(error.contains("a.rs: g: replace < with <=: explained"), "{error}");
        }
        assert!(render(&report(&["g", "g"]), &[known("g", 2)]).is_ok());
    }
}
