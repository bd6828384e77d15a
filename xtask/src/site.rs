//! The documentation site: guide, protocol, evidence and Python reference as one set of pages; beside them
//! the references of the crates, the C headers and the JavaScript package, and the page. One search.

use crate::files::copy;
use crate::test::ffi::doxygen;
use crate::test::python;
use crate::web;
use narx_report::steps::{self, Outcome, Step, output};
use narx_report::target_directory;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Crates whose reference is part of the site.
const CRATES: [&str; 3] = ["narx-core", "narx-board", "narx-boot"];

/// Arguments of `site`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Show the notebooks without running them
    #[arg(long)]
    still: bool,
    /// Leave out the page and the JavaScript reference, which need Node
    #[arg(long)]
    without_page: bool,
}

/// Builds the site into `target/site`. A link between pages that leads nowhere is an error.
pub(crate) fn command(root: &Path, arguments: &Arguments) -> ExitCode {
    let still = arguments.still;
    let mut steps = vec![
        Step::new("Python package", move || python::prepare(root).map(|_| Vec::new())),
        Step::new("guide", move || guide(root, still)),
        Step::new("crates", move || crates(root)),
        Step::new("C headers", move || headers(root)),
    ];
    if !arguments.without_page {
        steps.extend(web::build(root));
        steps.push(Step::new("page", move || {
            copy(&root.join("wasm/web/dist"), &site(root).join("page")).map(|()| Vec::new())
        }));
        steps.push(Step::new("JavaScript", move || javascript(root)));
        steps.push(Step::new("links beside the guide", move || linked(root)));
    }
    steps.push(Step::new("search", move || search(root)));
    steps::run_all(steps)
}

/// Folder of the site.
fn site(root: &Path) -> PathBuf {
    target_directory(root).join("site")
}

/// Builds the guide from the tracked files: the pages, and what they link to.
fn guide(root: &Path, still: bool) -> Outcome {
    let source = target_directory(root).join("site-source");
    for old in [&source, &site(root)] {
        // Pages of removed files must go.
        if old.exists() {
            fs::remove_dir_all(old).map_err(|error| format!("{}: {error}", old.display()))?;
        }
    }
    for file in output(Command::new("git").arg("ls-files").current_dir(root))?.lines() {
        copy(&root.join(file), &source.join(file))?;
    }
    copy(&root.join("docs/site/index.md"), &source.join("index.md"))?;
    copy(&root.join("python/docs/index.rst"), &source.join("python/reference.rst"))?;
    let sphinx = ["-m", "sphinx", "--quiet", "--fail-on-warning", "--keep-going", "--conf-dir"];
    let mut command = Command::new(python::prepare(root)?);
    command.args(sphinx).arg(root.join("docs/site")).arg(&source).arg(site(root));
    command.env("NARX_ROOT", root).env("NARX_NOTEBOOKS", if still { "off" } else { "force" });
    steps::run(command.env("PYTHONDONTWRITEBYTECODE", "1"))?;
    Ok(vec![site(root).join("index.html").display().to_string()])
}

/// Builds the reference of the crates; a link that leads nowhere is an error.
fn crates(root: &Path) -> Outcome {
    let made = target_directory(root).join("site-rust");
    let mut cargo = Command::new("cargo");
    cargo.args(["doc", "--quiet", "--no-deps", "--profile", "front"]).current_dir(root);
    cargo.args(CRATES.iter().flat_map(|name| ["-p", *name]));
    cargo.env("CARGO_TARGET_DIR", &made).env("RUSTDOCFLAGS", "-D warnings");
    steps::run(&mut cargo)?;
    copy(&made.join("doc"), &site(root).join("rust"))?;
    Ok(Vec::new())
}

/// Builds the reference of the C headers.
fn headers(root: &Path) -> Outcome {
    doxygen(root, &site(root), "HTML_OUTPUT = c\n")
}

/// Builds the reference of the JavaScript package from its type declarations; a link that leads nowhere is an
/// error.
fn javascript(root: &Path) -> Outcome {
    let mut typedoc = Command::new("npx");
    typedoc.args(["typedoc", "--options", "typedoc.json", "--out"]).arg(site(root).join("javascript"));
    steps::run(typedoc.current_dir(root.join("wasm/web")))
}

/// Makes the index of the search from all pages but listings of sources.
fn search(root: &Path) -> Outcome {
    let mut command = Command::new(python::prepare(root)?);
    command.args(["-m", "pagefind", "--quiet", "--site"]).arg(site(root));
    command.args(["--exclude-selectors", "aside, .col-sidebar, #top, #side-nav, #nav-path"]);
    command.args([
        "--glob",
        "{*.html,{docs,examples,python,ffi,board,tests,c,javascript,rust/narx_*}/**/*.html}",
    ]);
    steps::run(&mut command)
}

/// Checks the links from the first page to what was not built with it: all parts must be there.
fn linked(root: &Path) -> Outcome {
    let index = root.join("docs/site/index.md");
    let text = fs::read_to_string(&index).map_err(|error| format!("{}: {error}", index.display()))?;
    let links = text.split("href=\"").skip(1).filter_map(|rest| rest.split('"').next());
    let broken: Vec<&str> = links.filter(|link| !site(root).join(link).is_file()).collect();
    if broken.is_empty() { Ok(Vec::new()) } else { Err(format!("no such page: {}", broken.join(", "))) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files;

    /// Sphinx finds this out too, but takes minutes.
    #[test]
    fn every_page_is_in_the_index() {
        let root = narx_report::root();
        let index = files::read(&root.join("docs/site/index.md")).unwrap();
        let mut folders = vec!["docs".to_owned()];
        let examples = fs::read_dir(root.join("examples")).unwrap().flatten();
        folders.extend(examples.map(|example| format!("examples/{}", example.file_name().display())));
        for folder in folders.iter().filter(|folder| root.join(folder).is_dir()) {
            for page in fs::read_dir(root.join(folder)).unwrap().flatten() {
                let path = page.path();
                if path.extension().is_some_and(|kind| kind == "md") {
                    let line = format!("\n{folder}/{}\n", path.file_stem().unwrap_or_default().display());
                    assert!(index.contains(&line), "{} is in no table of contents", path.display());
                }
            }
        }
    }
}
