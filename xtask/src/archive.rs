//! A release of the C library: header, static libraries, CMake package, examples and texts in one folder and
//! one file.
//!
//! ```text
//!  narx-VERSION/   include/narx.h
//!                  lib/TARGET/libnarx.a        for each target
//!                  lib/TARGET/libnarx-small.a  for each processor: the same bits in less flash
//!                  lib/cmake/narx/             find_package(narx)
//!                  share/narx/examples/*.c     a piece of a hand-written driver each
//!                  README.md CHANGELOG.md PROTOCOL.md LICENSE-*
//! ```

use crate::cross;
use crate::install;
use crate::library::{self, Released};
use narx_report::steps::{self, Outcome};
use narx_report::target_directory;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const VERSION: &str = env!("CARGO_PKG_VERSION");
/// This machine's target triple, as Rust names it.
const HOST: &str = "x86_64-unknown-linux-gnu";

/// Runs `cargo xtask archive`.
pub(crate) fn command(root: &Path) -> ExitCode {
    steps::finish(pack(root))
}

/// Builds the libraries, lays the release out and packs it; returns the closing line.
fn pack(root: &Path) -> Outcome {
    install::debian(&[cross::PACKAGES, cross::RISCV_PACKAGES].concat())?;
    let libraries = library::released();
    libraries.iter().try_for_each(|(library, processor)| library.build(root, *processor).map(drop))?;
    let folder = lay_out(root, &libraries)?;
    let name = name();
    let file = target_directory(root).join(format!("{name}.tar.gz"));
    let mut tar = Command::new("tar");
    // Equal files give equal archives.
    tar.args(["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=@0", "-czf"]);
    tar.arg(&file).arg("-C").arg(folder.parent().unwrap_or(root)).arg(&name);
    steps::run(&mut tar)?;
    let bytes = fs::metadata(&file).map_err(|error| format!("{}: {error}", file.display()))?.len();
    Ok(vec![format!("{}: {} KB", file.display(), bytes / 1024)])
}

/// Lays a release of these libraries out, which are built; returns its folder.
///
/// # Errors
/// Fails with the name of a file that cannot be written.
pub(crate) fn lay_out(root: &Path, libraries: &[Released]) -> Result<PathBuf, String> {
    let folder = target_directory(root).join(name());
    // Files of an earlier version must not stay.
    let _ = fs::remove_dir_all(&folder);
    let package = folder.join("lib/cmake/narx");
    copy(&root.join("ffi/include/narx.h"), &folder.join("include/narx.h"))?;
    for &(library, processor) in libraries {
        let (target, strip) = processor
            .map_or((HOST, "strip".to_owned()), |processor| (processor.target(), processor.tool("strip")));
        let file = folder.join("lib").join(target).join(library.file());
        copy(&library.path(root, processor), &file)?;
        // Debug information holds the folders of the sources and is of no use to a user.
        steps::run(Command::new(strip).arg("--strip-debug").arg(&file))?;
    }
    copy(&root.join("ffi/cmake/narxConfig.cmake"), &package.join("narxConfig.cmake"))?;
    let version = read(&root.join("ffi/cmake/narxConfigVersion.cmake"))?.replace("@VERSION@", VERSION);
    write(&package.join("narxConfigVersion.cmake"), &version)?;
    let examples = root.join("ffi/examples");
    for entry in
        fs::read_dir(&examples).map_err(|error| format!("{}: {error}", examples.display()))?.flatten()
    {
        copy(&entry.path(), &folder.join("share/narx/examples").join(entry.file_name()))?;
    }
    copy(&root.join("ffi/README.md"), &folder.join("README.md"))?;
    for text in ["CHANGELOG.md", "PROTOCOL.md", "LICENSE-APACHE", "LICENSE-MIT"] {
        copy(&root.join(text), &folder.join(text))?;
    }
    Ok(folder)
}

fn name() -> String {
    format!("narx-{VERSION}")
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    make_parent(to)?;
    fs::copy(from, to).map(drop).map_err(|error| format!("{}: {error}", from.display()))
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    make_parent(path)?;
    fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

fn make_parent(path: &Path) -> Result<(), String> {
    let parent = path.parent().unwrap_or(path);
    fs::create_dir_all(parent).map_err(|error| format!("{}: {error}", parent.display()))
}
