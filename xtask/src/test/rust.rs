//! Tests of the core and the bench on this machine, the build for a target without std, and our files in
//! other people's tools.

use crate::image::EMBEDDED;
use crate::programs::{GENERATE, LAB};
use crate::{callgrind, install, interop};
use narx_report::steps::Step;
use std::path::Path;

/// Steps in their order.
pub(crate) fn steps(root: &Path) -> Vec<Step<'_>> {
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
                "check",
                "-p",
                "narx-core",
                "-p",
                "narx-sim",
                "-p",
                "narx-boot",
                "-p",
                "narx-board",
                "--no-default-features",
                "--target",
                EMBEDDED,
            ],
        ),
        // Alone, because together with other packages the core gets their features.
        Step::command(root, "without features", "cargo", &["test", "--profile", "front", "-p", "narx-small"]),
        Step::new("vectors", move || LAB.run(root, &["vectors", "--check"])),
        Step::new("documents", move || GENERATE.run(root, &["documents", "--check"])),
        Step::new("callgrind", move || callgrind::regenerate(root, true)),
        Step::new("interoperability", move || interop::run(root)),
    ]
}
