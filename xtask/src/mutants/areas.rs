//! Areas of the code that are mutated, and the tests that must notice.

/// Test programs of a package.
pub(super) struct Tests {
    /// Name of the package.
    pub(crate) package: &'static str,
    /// Features that the tests need.
    pub(crate) features: &'static str,
    /// Names of the programs.
    pub(crate) programs: &'static [&'static str],
    /// Tests to skip: they do not concern the area and take long.
    pub(crate) skip: &'static [&'static str],
    /// Time after which a mutant counts as hung, s: ten times the tests' duration on two busy cores.
    pub(crate) timeout: &'static str,
}

/// Some files, and the tests that concern them.
pub(super) struct Area {
    /// Name of the area on the command line.
    pub(crate) name: &'static str,
    /// Description of the area for the page.
    pub(crate) what: &'static str,
    /// Package that is mutated.
    pub(crate) package: &'static str,
    /// Files of the package, as globs.
    pub(crate) files: &'static [&'static str],
    /// Tests that are run against every mutant: built in seconds.
    pub(crate) quick: Tests,
    /// Tests that take longer, if there are any; run against the mutants that the quick ones miss.
    pub(crate) long: Option<Tests>,
}

const fn quick(programs: &'static [&'static str], features: &'static str) -> Tests {
    Tests { package: "narx-mutants", features, programs, skip: &[], timeout: "40" }
}

/// Tests with every cut, every bit and every page's life, again and again: the other tests of storage find
/// most failures sooner.
const LONG: [&str; 6] = [
    "code_flash_damage::a_flipped_bit",
    "every_cut_of_",
    "flips::",
    "log::a_log_is_a_list",
    "log::fallen_bits",
    "store::wear_is_even",
];

/// All areas.
pub(super) const AREAS: [Area; 6] = [
    Area {
        name: "tick",
        what: "control tick: measurement, rotor, control, commutation",
        package: "narx-core",
        files: &[
            "core/src/motor/{band,clock,drive,gain,interval,ramp,rotor,signal}.rs",
            "core/src/motor/{commutate,drive,rotor,sense}/**/*.rs",
            "core/src/motor/control.rs",
            "core/src/motor/control/{coast,pi,steady}.rs",
            "core/src/motor/guard/{open_phase,rails}.rs",
        ],
        quick: quick(&["replay"], ""),
        long: Some(Tests { timeout: "120", ..quick(&["machine", "drive"], "bench") }),
    },
    Area {
        name: "machine",
        what: "state machine, faults, protection",
        package: "narx-core",
        files: &[
            "core/src/motor/{machine,machine/state,guard/fault,guard/protection}.rs",
            "core/src/motor/guard/protection/*.rs",
        ],
        quick: quick(&["machine"], ""),
        long: Some(Tests { timeout: "120", ..quick(&["drive"], "bench") }),
    },
    Area {
        name: "boot",
        what: "bootloader: images, slots, swap",
        package: "narx-boot",
        files: &["boot/src/*.rs"],
        quick: Tests { package: "narx-boot", features: "", programs: &["boot"], skip: &[], timeout: "120" },
        long: None,
    },
    Area {
        name: "storage",
        what: "parameters and log in the flash",
        package: "narx-core",
        files: &["core/src/storage/**/*.rs"],
        quick: Tests { skip: &LONG, timeout: "20", ..quick(&["storage"], "bench") },
        long: Some(Tests { timeout: "120", ..quick(&["storage"], "bench") }),
    },
    Area {
        name: "narmotion",
        what: "frames, candump and messages of NarMotion-X",
        package: "narx-core",
        files: &["core/src/bus/*.rs", "core/src/bus/narmotion/*.rs"],
        quick: quick(&["narmotion"], ""),
        // Both protocols share the frames.
        long: Some(quick(&["eddycan"], "")),
    },
    Area {
        name: "eddycan",
        what: "messages of eddyCAN",
        package: "narx-core",
        files: &["core/src/bus/eddycan/*.rs"],
        quick: quick(&["eddycan"], ""),
        long: None,
    },
];

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::path::Path;

    /// Every program exists under its name; one that does not would notice nothing.
    #[test]
    fn every_program_is_there() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        for area in &AREAS {
            for tests in [Some(&area.quick), area.long.as_ref()].into_iter().flatten() {
                let folder = match tests.package {
                    "narx-mutants" => "tests/mutants",
                    _ => "boot",
                };
                let manifest = fs::read_to_string(root.join(folder).join("Cargo.toml")).unwrap();
                for program in tests.programs {
                    assert!(manifest.contains(&format!("name = \"{program}\"")), "{}: {program}", area.name);
                }
            }
        }
    }
}
