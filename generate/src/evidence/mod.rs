//! docs/EVIDENCE.md and its pages in docs/evidence: the claims of narx with their figures, each with the
//! command that measures it again. The pages are templates, filled with the figures that are committed in
//! docs/evidence; measuring them takes minutes to hours, making the pages does not.

use crate::Made;
use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, Error, ErrorKind, UndefinedBehavior};
use narx_report::figures::{self, Figure};
use serde_json::{Map, Value};
use std::ffi::OsStr;
use std::fmt::Display;
use std::fs;
use std::path::Path;

/// Macros that every page may use, and checks of the figures.
const MACROS: &str = include_str!("pages/macros.jinja");
/// The pages and their templates: the summary, then its details.
const PAGES: [(&str, &str); 12] = [
    ("docs/EVIDENCE.md", include_str!("pages/summary.md.jinja")),
    ("docs/evidence/promises.md", include_str!("pages/promises.md.jinja")),
    ("docs/evidence/quality.md", include_str!("pages/quality.md.jinja")),
    ("docs/evidence/starts.md", include_str!("pages/starts.md.jinja")),
    ("docs/evidence/bits.md", include_str!("pages/bits.md.jinja")),
    ("docs/evidence/worlds.md", include_str!("pages/worlds.md.jinja")),
    ("docs/evidence/bytes.md", include_str!("pages/bytes.md.jinja")),
    ("docs/evidence/mutants.md", include_str!("pages/mutants.md.jinja")),
    ("docs/evidence/branches.md", include_str!("pages/branches.md.jinja")),
    ("docs/evidence/proof.md", include_str!("pages/proof.md.jinja")),
    ("docs/evidence/cost.md", include_str!("pages/cost.md.jinja")),
    ("docs/evidence/speed.md", include_str!("pages/speed.md.jinja")),
];

/// Folder of the figures, and of the reasons for what they miss.
const FIGURES: &str = "docs/evidence";
/// Further files: results of the proofs, and the list of all fuzz targets.
const MORE: [&str; 2] = ["tests/golden/proof.toml", "tests/fuzz/Cargo.toml"];

/// Contents of the files by their names without ending.
type Figures = Map<String, Value>;

/// Makes the pages.
///
/// # Errors
/// Fails if figures are missing, or a missed goal has no reason.
pub fn make(root: &Path) -> Result<Made, String> {
    let figures = read(root)?;
    gaps_exist(root, &figures)?;
    let texts = render(&figures).map_err(|error| error.to_string())?;
    let lines: usize = texts.iter().map(|text| text.lines().count()).sum();
    let files = PAGES.iter().zip(texts).map(|((path, _), text)| ((*path).into(), text)).collect();
    Ok(Made { summary: format!("{lines} lines of evidence"), files })
}

fn read(root: &Path) -> Result<Figures, String> {
    let mut found = Figures::new();
    let folder = fs::read_dir(root.join(FIGURES)).map_err(|error| format!("{FIGURES}: {error}"))?;
    for path in folder.flatten().map(|file| file.path()).chain(MORE.map(|path| root.join(path))) {
        let failed = |error: &dyn Display| format!("{}: {error}", path.display());
        let text = fs::read_to_string(&path).map_err(|error| failed(&error))?;
        let content = match path.extension().and_then(OsStr::to_str) {
            Some("json") => serde_json::from_str(&text).map_err(|error| failed(&error))?,
            Some("toml") => toml::from_str(&text).map_err(|error| failed(&error))?,
            _ => continue,
        };
        found.insert(path.file_stem().unwrap_or_default().to_string_lossy().into_owned(), content);
    }
    Ok(found)
}

/// Checks that every file of the core whose gap is explained exists.
fn gaps_exist(root: &Path, figures: &Figures) -> Result<(), String> {
    let gaps = figures.get("gaps").and_then(Value::as_object).into_iter().flatten();
    let gone = gaps.map(|(name, _)| name).filter(|name| !root.join("core/src").join(name).is_file());
    let gone: Vec<String> =
        gone.map(|name| format!("docs/evidence/gaps.toml: there is no core/src/{name}")).collect();
    if gone.is_empty() { Ok(()) } else { Err(gone.join("\n")) }
}

/// Texts of [`PAGES`].
fn render(figures: &Figures) -> Result<Vec<String>, Error> {
    let mut page = Environment::new();
    page.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    // A figure that the template asks for and a file does not have is an error.
    page.set_undefined_behavior(UndefinedBehavior::Strict);
    page.add_filter("cell", |text: String| text.replace('|', "\\|"));
    page.add_filter("value", |Serde(figure): Serde<Figure>| figures::value(&figure));
    page.add_test("missed", |Serde(figure): Serde<Figure>| !figure.is_met());
    page.add_function("fail", |message: String| -> Result<String, Error> {
        Err(Error::new(ErrorKind::InvalidOperation, message))
    });
    let filled = |(path, template): &(&str, &str)| {
        page.render_named_str(path, &format!("{MACROS}{template}"), Serde(figures))
    };
    PAGES.iter().map(filled).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn root() -> &'static Path {
        Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
    }

    /// Pages of the committed figures after a change, one after the other.
    fn changed(change: impl FnOnce(&mut Figures)) -> Result<String, String> {
        let mut figures = read(root()).unwrap();
        change(&mut figures);
        render(&figures).map(|texts| texts.join("\n")).map_err(|error| error.to_string())
    }

    /// Every page of details has the command that measures it again, and the summary links to it.
    #[test]
    fn every_page_says_what_measures_it() {
        let texts = render(&read(root()).unwrap()).unwrap();
        for ((path, _), text) in PAGES.iter().zip(&texts).skip(1) {
            assert!(text.contains("`cargo xtask "), "{path} names no command");
            let link = format!("]({})", path.trim_start_matches("docs/"));
            assert!(texts[0].contains(&link), "the summary has no link to {path}");
        }
    }

    #[test]
    fn what_nobody_has_measured_says_so_and_how() {
        for (name, text) in [
            ("bench", "bench.json is not there: cargo xtask bench --all --out docs/evidence"),
            ("quality", "quality.json is not there: cargo xtask quality"),
            ("starts", "starts.json is not there: cargo xtask certificate"),
            ("mutants", "mutants.json is not there: cargo xtask mutants --out docs/evidence"),
            ("conformance", "\nNot measured: `cargo xtask conformance --out docs/evidence`.\n"),
            ("worlds", "\nNot measured: `cargo xtask worlds --hours 100 --first 20261122 --out"),
            ("branches", "\nNot measured: `cargo xtask branches`.\n"),
            ("fuzz", "\n`cargo xtask fuzz --out docs/evidence`: not measured.\n"),
            ("fuzz", "`cargo xtask fuzz --identifiers --out docs/evidence`: not measured.\n"),
        ] {
            let page = changed(|figures| drop(figures.remove(name))).unwrap_or_else(|error| error);
            assert!(page.contains(text), "{page}");
        }
        let page = changed(|figures| {
            figures["bench"]["parts"] = json!([
                {"part": "soon", "command": "measure it", "skipped": "a | b", "figures": []},
            ]);
            figures["mutants"]["areas"] = json!([]);
            figures["survivors"] = json!({});
            figures["fuzz"]["targets"].as_array_mut().unwrap().remove(0);
        });
        for line in [
            "| `measure it` | | | | |\n| soon | not measured | | | a \\| b |\n",
            "| `cargo xtask bench --only logs` | | | | |\n| logs | not measured | | |  |\n",
            "| messages of eddyCAN | | not run | | | | | |\n",
            "| boot | not measured | | | | |\n",
        ] {
            assert!(page.as_ref().unwrap().contains(line), "no {line}");
        }
    }

    /// Puts a figure with this value and the goal `<= 2` on the page, and gives the reason why it is missed.
    fn judged(figures: &mut Figures, value: Value, reason: Option<&str>) {
        figures["starts"]["part"]["figures"] =
            json!([{"name": "jitter", "figure": value, "unit": "", "goal": "<= 2", "note": "a | b"}]);
        figures["missed"].as_object_mut().unwrap().extend(reason.map(|it| ("jitter".to_owned(), it.into())));
    }

    #[test]
    fn what_is_missed_is_explained_and_nothing_else() {
        let page = changed(|figures| judged(figures, json!(2.5), Some("noise"))).unwrap();
        assert!(page.contains("| jitter | 2.500 | <= 2 | *missed* | a \\| b |\n"), "{page}");
        assert!(page.contains("\n\nWhat is missed, and why:\n\n* *jitter*: noise\n\n"), "{page}");
        let missed = changed(|figures| judged(figures, Value::Null, None)).unwrap_err();
        assert!(missed.contains("\"jitter\" is missed, and docs/evidence/missed.toml does not"), "{missed}");
        let met = changed(|figures| judged(figures, json!(2), Some("noise"))).unwrap_err();
        assert!(met.contains("\"jitter\" is explained in docs/evidence/missed.toml but not missed"), "{met}");
        let beyond = |of: &str, metric: &str| {
            changed(|figures| {
                for row in figures["quality"]["rows"].as_array_mut().unwrap() {
                    if row["of"] == of && row["metric"] == metric {
                        row["outside"] = json!(1);
                    }
                }
            })
        };
        let step = "steady speed error, mean";
        let missed = beyond("presets", step).unwrap_err();
        assert!(missed.contains("\"presets, hall: steady speed error, mean\" is missed"), "{missed}");
        // Neither can be seen, nor does a limit allow it.
        assert!(beyond("presets, unseen", step).is_ok());
        assert!(beyond("presets", "points that the drive's limits forbid").is_ok());
    }

    #[test]
    fn rooms_add_up_and_every_gap_is_explained_or_open() {
        let page = |explained: &str| {
            changed(|figures| {
                figures["branches"]["files"] = json!({
                    "motor/control/pi.rs": {"branches": 4, "covered": 4},
                    "motor/ramp.rs": {"branches": 6, "covered": 5},
                    "none.rs": {"branches": 0, "covered": 0},
                    "units.rs": {"branches": 2, "covered": 0},
                });
                figures["gaps"] = json!({explained: "const"});
            })
        };
        let text = page("units.rs").unwrap();
        for line in [
            "| `motor` | 2 | 10 | 9 | 90.0 % |\n| `none` | 1 | 0 | 0 | 100.0 % |\n| `units` | 1 | 2 | 0 | 0.0 % |\n",
            "| all | 4 | 12 | 9 | 75.0 % |\n",
            "|---|\n| `units.rs` | 2 | 2 | const |\n| `motor/ramp.rs` | 1 | 6 | *open* |\n\n",
        ] {
            assert!(text.contains(line), "no {line} in\n{text}");
        }
        let error = page("motor/control/pi.rs").unwrap_err();
        assert!(error.contains("\"motor/control/pi.rs\" is explained in docs/evidence/gaps.toml"), "{error}");
    }

    #[test]
    fn a_gap_of_a_file_that_is_gone_is_an_error() {
        let mut figures = read(root()).unwrap();
        assert_eq!(gaps_exist(root(), &figures), Ok(()));
        figures["gaps"]["motor/gone.rs"] = json!("a guard");
        let error = "docs/evidence/gaps.toml: there is no core/src/motor/gone.rs";
        assert_eq!(gaps_exist(root(), &figures), Err(error.to_owned()));
    }

    /// An explanation applies to all mutants of a name, or to none.
    #[test]
    fn a_survivor_is_open_or_explained() {
        let page = |missed: &[&str], known: &str, times: u32| {
            let mutant =
                |name: &str| json!({"file": "a.rs", "function": name, "mutation": "replace * with <="});
            changed(|figures| {
                let missed: Vec<Value> = missed.iter().map(|name| mutant(name)).collect();
                figures["mutants"]["areas"] = json!([{
                    "what": "boot", "mutants": 9, "run": 8, "caught": 4, "timeout": 1, "unviable": 1, "missed": missed,
                }]);
                let mut known = mutant(known);
                (known["times"], known["reason"]) = (times.into(), "equal".into());
                figures["survivors"]["survivor"] = json!([known]);
            })
        };
        let text = page(&["f", "g"], "g", 1).unwrap();
        assert!(text.contains("| boot | 9 | 8 | 4 | 1 | 1 | 1 | 1 |\n"), "{text}");
        assert!(text.contains("\n\nOpen:\n\n* `a.rs`, `f`, *replace \\* with <=*\n\nSurvivors"), "{text}");
        assert!(text.contains(":\n\n* `a.rs`, `g`, *replace \\* with <=*: equal\n\n"), "{text}");
        assert!(page(&["", ""], "", 2).unwrap().contains("* `a.rs`, `a constant`, *replace"));
        for (missed, times) in [(&["f"][..], 1), (&["g", "g"], 1), (&["g"], 2)] {
            let error = page(missed, "g", times).unwrap_err();
            assert!(error.contains("a.rs: g: replace * with <=: explained"), "{error}");
        }
    }

    #[test]
    fn a_finding_of_the_fuzzers_is_open() {
        let page = changed(|figures| figures["fuzz"]["targets"][0]["findings"] = json!(["a | b"])).unwrap();
        assert!(page.contains("\n\nOpen, boot: a \\| b\n\nEvery identifier"), "{page}");
    }
}
