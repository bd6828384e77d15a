//! The C header `ffi/include/narx.h`, made from the C interface, the core's enumerations and coefficients,
//! and the core's tables.

mod tables;

use crate::Made;
use cbindgen::{Builder, Config};
use std::path::Path;

/// Makes the header.
///
/// # Errors
/// Fails with cbindgen's message.
pub fn make(root: &Path) -> Result<Made, String> {
    let text = header(root)?;
    Ok(Made { summary: format!("{} lines of C", text.lines().count()), files: vec![(HEADER.into(), text)] })
}

const HEADER: &str = "ffi/include/narx.h";

/// Files of the core with the enumerations and the coefficients that the header contains.
const TYPES: [&str; 23] = [
    "core/src/blocks/hall.rs",
    "core/src/blocks/pi.rs",
    "core/src/blocks/ramp.rs",
    "core/src/blocks/zero_crossing.rs",
    "core/src/motor/coefficients.rs",
    "core/src/motor/commutate/commutation.rs",
    "core/src/motor/commutate/commutator.rs",
    "core/src/motor/commutate/pwm.rs",
    "core/src/motor/control/coefficients.rs",
    "core/src/motor/control/limits.rs",
    "core/src/motor/control/pi.rs",
    "core/src/motor/gain.rs",
    "core/src/motor/guard/protection.rs",
    "core/src/motor/guard/rails.rs",
    "core/src/motor/machine.rs",
    "core/src/motor/machine/state.rs",
    "core/src/motor/rotor/back_emf.rs",
    "core/src/motor/rotor/hall.rs",
    "core/src/motor/rotor/hall_calibration.rs",
    "core/src/motor/rotor/open_loop.rs",
    "core/src/motor/rotor/sensorless.rs",
    "core/src/motor/sense/measurement.rs",
    "core/src/motor/sense/samples.rs",
];

/// File with the parameters' numbers.
const NUMBERS: &str = "core/src/dictionary/number.rs";

fn header(root: &Path) -> Result<String, String> {
    let config = Config::from_file(root.join("ffi/cbindgen.toml"))?;
    let mut builder = Builder::new()
        .with_config(config)
        .with_crate(root.join("ffi"))
        .with_after_include(numbers(root)? + "\n" + &tables::definitions());
    for file in TYPES {
        builder = builder.with_src(root.join(file));
    }
    // Types end in _t; their enumerators need not.
    Ok(without_lists(&text(builder)?).replace("_T_", "_"))
}

/// Removes the list `ALL` of an enumeration, with its comment: it contains names that C does not have.
fn without_lists(text: &str) -> String {
    let mut lines: Vec<&str> = Vec::new();
    for line in text.lines() {
        if line.starts_with("#define narx_") {
            while lines.pop_if(|comment| comment.starts_with("//")).is_some() {}
        } else if !(line.is_empty() && lines.last().is_none_or(|before| before.is_empty())) {
            lines.push(line);
        }
    }
    lines.join("\n") + "\n"
}

/// Renders the parameters' numbers as `NARX_PARAMETER_NAME`.
fn numbers(root: &Path) -> Result<String, String> {
    let mut config = Config { no_includes: true, language: cbindgen::Language::C, ..Config::default() };
    config.documentation_style = cbindgen::DocumentationStyle::C99;
    config.export.prefix = Some(String::from("NARX_PARAMETER_"));
    text(Builder::new().with_config(config).with_src(root.join(NUMBERS)))
}

fn text(builder: Builder) -> Result<String, String> {
    let bindings = builder.generate().map_err(|error| format!("cbindgen: {error}"))?;
    let mut bytes = Vec::new();
    bindings.write(&mut bytes);
    String::from_utf8(bytes).map_err(|error| format!("{HEADER}: {error}"))
}
