//! Tests of the core and the bench on this machine, the build for a target without std, and our files in
//! other people's tools.

use crate::steps::Step;
use crate::{callgrind, coverage, dbc, eds, install, interop, readme, vectors};
use std::path::Path;

/// Target of a Cortex-M4 with floating point, as on the boards.
pub const EMBEDDED: &str = "thumbv7em-none-eabihf";

/// Steps in their order.
pub fn steps(root: &Path) -> Vec<Step<'_>> {
    vec![
        Step::command(root, "format", "cargo", &["fmt", "--all", "--check"]),
        Step::command(
            root,
            "lints",
            "cargo",
            &["clippy", "--workspace", "--all-targets", "--quiet", "--", "-D", "warnings"],
        ),
        Step::command(root, "tests", "cargo", &["test", "--no-fail-fast"]),
        // Fails for a package that uses std or the heap: the target has neither.
        Step::new("Cortex-M target", || install::rust_target(EMBEDDED)),
        Step::command(
            root,
            "no_std",
            "cargo",
            &[
                "build",
                "-p",
                "narx-core",
                "-p",
                "narx-sim",
                "-p",
                "narx-boot",
                "--no-default-features",
                "--target",
                EMBEDDED,
            ],
        ),
        // Alone, because together with other packages the core gets their features.
        Step::command(root, "without features", "cargo", &["test", "-p", "narx-small"]),
        Step::new("vectors", move || vectors::regenerate(root, true)),
        Step::new("coverage", move || coverage::regenerate(root, true)),
        Step::new("CAN database", move || dbc::regenerate(root, true)),
        Step::new("EDS", move || eds::regenerate(root, true)),
        Step::new("pictures", move || readme::regenerate(root, true)),
        Step::new("callgrind", move || callgrind::regenerate(root, true)),
        Step::new("interoperability", move || interop::run(root)),
    ]
}
