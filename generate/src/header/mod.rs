//! The C headers, made from the C interface, the core's enumerations and coefficients, and the core's tables:
//! `narx.h` has the functions, `narx_types.h` their types, `narx_tables.h` numbers and names from the tables.

mod tables;

use crate::Made;
use cbindgen::{Builder, Config};
use std::path::Path;

/// Makes the headers.
///
/// # Errors
/// Fails with cbindgen's message.
pub fn make(root: &Path) -> Result<Made, String> {
    let files = headers(root)?;
    let lines: usize = files.iter().map(|(_, text)| text.lines().count()).sum();
    let files = files.map(|(name, text)| (format!("ffi/include/{name}"), text)).into();
    Ok(Made { summary: format!("{lines} lines of C"), files })
}

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

/// Renders the three headers. cbindgen writes one text, types first; it is cut where the functions begin.
fn headers(root: &Path) -> Result<[(&'static str, String); 3], String> {
    const FUNCTIONS: &str = "#ifdef __cplusplus\nextern \"C\" {";
    let config = Config::from_file(root.join("ffi/cbindgen.toml"))?;
    let mut builder = Builder::new().with_config(config).with_crate(root.join("ffi"));
    for file in TYPES {
        builder = builder.with_src(root.join(file));
    }
    // Types end in _t; their enumerators need not.
    let text = without_strangers(&text(builder)?).replace("_T_", "_");
    let (about, rest) = text.split_once("*/\n").ok_or("the head of the header is no comment")?;
    let (types, functions) = rest.split_once(FUNCTIONS).ok_or("the header has no functions")?;
    let tables = numbers(root)? + "\n" + &tables::definitions();
    Ok([
        ("narx.h", guarded("narx", about, "narx_types.h", &format!("{FUNCTIONS}{functions}"))),
        ("narx_types.h", guarded("narx_types", TYPES_ABOUT, "narx_tables.h", types)),
        ("narx_tables.h", guarded("narx_tables", TABLES_ABOUT, "stdint.h", &tables)),
    ])
}

const TYPES_ABOUT: &str = "/**
 * @file
 * Types of narx.h, which includes this file. Made by `cargo xtask header`: do not edit.
 ";
const TABLES_ABOUT: &str = "/**
 * @file
 * Numbers and names of parameters, faults, messages and their fields, from the tables of the protocol (PROTOCOL.md).
 * narx.h includes this file. Made by `cargo xtask header`: do not edit.
 ";

/// Puts a header together: its head, a guard, the file that it includes, and its content.
fn guarded(name: &str, about: &str, included: &str, content: &str) -> String {
    let guard = format!("{}_H", name.to_uppercase());
    let include =
        if included.starts_with("narx") { format!("\"{included}\"") } else { format!("<{included}>") };
    let content = content.trim();
    format!(
        "{about}*/\n\n#ifndef {guard}\n#define {guard}\n\n#include {include}\n\n{content}\n\n#endif // {guard}\n"
    )
}

/// Removes constants whose names are not of this header, with their comments: C does not know their values.
/// The integer of an enumeration, which has no comment, gets one.
fn without_strangers(text: &str) -> String {
    let mut lines: Vec<&str> = Vec::new();
    for line in text.lines() {
        if line.starts_with("#define ") && !line.starts_with("#define NARX_") {
            while lines.pop_if(|comment| comment.starts_with("//")).is_some() {}
        } else if line.starts_with("typedef ") && line.ends_with("_t;") {
            lines.extend(["/// A value of the enumeration.", line]);
        } else if !(line.is_empty() && lines.last().is_none_or(|before| before.is_empty())) {
            lines.push(line);
        }
    }
    lines.join("\n") + "\n"
}

/// Renders the parameters' numbers as `NARX_PARAMETER_NAME`.
fn numbers(root: &Path) -> Result<String, String> {
    let mut config = Config { no_includes: true, language: cbindgen::Language::C, ..Config::default() };
    config.documentation_style = cbindgen::DocumentationStyle::Cxx;
    config.export.prefix = Some(String::from("NARX_PARAMETER_"));
    text(Builder::new().with_config(config).with_src(root.join(NUMBERS)))
}

fn text(builder: Builder) -> Result<String, String> {
    let bindings = builder.generate().map_err(|error| format!("cbindgen: {error}"))?;
    let mut bytes = Vec::new();
    bindings.write(&mut bytes);
    String::from_utf8(bytes).map_err(|error| format!("the C header: {error}"))
}
