//! A release of the C library: header, static libraries, CMake package, examples and texts in one folder and
//! one file.
//!
//! ```text
//!  narx-VERSION/   include/narx.h              functions; it includes types and tables
//!                  lib/TARGET/libnarx.a        for each target
//!                  lib/TARGET/libnarx-small.a  for each processor: the same bits in less flash
//!                  lib/TARGET/pkgconfig/       pkg-config
//!                  lib/cmake/narx/             find_package(narx)
//!                  CMakeLists.txt              FetchContent
//!                  library.json                PlatformIO
//!                  zephyr/                     a module of Zephyr
//!                  share/narx/examples/*.c     a piece of a hand-written driver each
//!                  share/narx/sizes.toml       flash, RAM and instructions of each part
//!                  README.md CHANGELOG.md PROTOCOL.md LICENSE-*
//! ```

use crate::cross;
use crate::files::{self, copy, read, write};
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
    let file = folder.with_file_name(format!("{}.tar.gz", name()));
    files::pack(&folder, &file)?;
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
    copy(&root.join("ffi/include"), &folder.join("include"))?;
    for &(library, processor) in libraries {
        let (target, strip) = processor
            .map_or((HOST, "strip".to_owned()), |processor| (processor.target(), processor.tool("strip")));
        let file = folder.join("lib").join(target).join(library.file());
        copy(&library.path(root, processor), &file)?;
        // Debug information holds the folders of the sources and is of no use to a user.
        steps::run(Command::new(strip).arg("--strip-debug").arg(&file))?;
        let system = if processor.is_none() { " -lpthread -ldl -lm" } else { "" };
        let package = read(&root.join("ffi/package/narx.pc"))?;
        let package = package.replace("@VERSION@", VERSION).replace("@SYSTEM@", system);
        write(&file.with_file_name("pkgconfig/narx.pc"), &package)?;
    }
    let from = root.join("ffi/package");
    for (name, to) in [
        ("narxConfig.cmake", "lib/cmake/narx/narxConfig.cmake"),
        ("CMakeLists.txt", "CMakeLists.txt"),
        ("Doxyfile", "share/narx/Doxyfile"),
        ("platformio.py", "share/narx/platformio.py"),
    ] {
        copy(&from.join(name), &folder.join(to))?;
    }
    for (name, to) in [
        ("narxConfigVersion.cmake", "lib/cmake/narx/narxConfigVersion.cmake"),
        ("library.json", "library.json"),
    ] {
        write(&folder.join(to), &read(&from.join(name))?.replace("@VERSION@", VERSION))?;
    }
    copy(&from.join("zephyr"), &folder.join("zephyr"))?;
    copy(&root.join("ffi/examples"), &folder.join("share/narx/examples"))?;
    copy(&root.join("tests/golden/ffi_sizes.toml"), &folder.join("share/narx/sizes.toml"))?;
    copy(&root.join("ffi/README.md"), &folder.join("README.md"))?;
    for text in ["CHANGELOG.md", "PROTOCOL.md", "LICENSE-APACHE", "LICENSE-MIT"] {
        copy(&root.join(text), &folder.join(text))?;
    }
    Ok(folder)
}

fn name() -> String {
    format!("narx-{VERSION}")
}
