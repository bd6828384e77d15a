//! `ffi/src/blocks/settings.rs`: the settings of the blocks as C sees them, made from the core's structs.
//!
//! C has no `bool` that may hold any byte, and no fixed-point types. So each struct is written again with
//! plain integers, and converted both ways.

use crate::Made;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use syn::{Attribute, Expr, Field, Fields, Item, ItemStruct, Lit, Meta, Type};

const PATH: &str = "ffi/src/blocks/settings.rs";

/// Files of `core/src/blocks` with a struct of settings.
const BLOCKS: [&str; 7] = ["commutation", "fault", "hall", "pi", "ramp", "state", "zero_crossing"];

const HEAD: &str =
    "//! Settings of the blocks, made from the structs of `narx_core::blocks` by `cargo xtask header`.

use super::gain::gain;
use crate::board::narx_channel_t;
use narx_core::blocks::{
    CommutationSettings, FaultSettings, HallSettings, PiSettings, RampSettings, SettingError, StateSettings,
    ZeroCrossingSettings,
};
use narx_core::motor::Lines;
use narx_core::motor::gain::Gain;
use narx_core::units::{Amps, Celsius, ElectricalSpeed, Volts};
";

/// Makes the file.
///
/// # Errors
/// Fails if a struct has a field of a type that has no counterpart in C.
pub fn make(root: &Path) -> Result<Made, String> {
    let mut text = String::from(HEAD);
    for block in BLOCKS {
        let path = format!("core/src/blocks/{block}.rs");
        let source = fs::read_to_string(root.join(&path)).map_err(|error| format!("{path}: {error}"))?;
        let file = syn::parse_file(&source).map_err(|error| format!("{path}: {error}"))?;
        let settings = file.items.iter().find_map(|item| match item {
            Item::Struct(found) if found.ident.to_string().ends_with("Settings") => Some(found),
            _ => None,
        });
        let settings = settings.ok_or_else(|| format!("{path}: has no struct of settings"))?;
        // Derived or written, it is named in the file; of a block without, no settings reach C.
        let defaults = source.contains("Default");
        text += &render(block, settings, defaults).map_err(|error| format!("{path}: {error}"))?;
    }
    Ok(Made { summary: format!("settings of {} blocks", BLOCKS.len()), files: vec![(PATH.into(), text)] })
}

/// Renders the struct of a block and its conversions, that to C only if there are default values to convert.
fn render(block: &str, settings: &ItemStruct, defaults: bool) -> Result<String, String> {
    let Fields::Named(fields) = &settings.fields else { return Err("settings without names".into()) };
    let core = &settings.ident;
    let name = format!("narx_{block}_settings_t");
    let (mut declared, mut to_c, mut to_core) = (String::new(), String::new(), String::new());
    for field in &fields.named {
        let Counterpart { name, c, note, to_c: there, to_core: back } = counterpart(field)?;
        declared += &comment("    ", &note(&doc(&field.attrs)));
        let _ = writeln!(declared, "    pub {name}: {c},");
        let _ = writeln!(to_c, "            {name}: {there},");
        let _ = writeln!(to_core, "            {name}: {back},");
    }
    let about = doc(&settings.attrs);
    let about = about.split_once("].").map_or("", |(_, rest)| rest);
    let about = comment("", &format!("Settings for narx_{block}_init.{about}"));
    let mut text = format!(
        "
{about}#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct {name} {{
{declared}}}

impl TryFrom<&{name}> for {core} {{
    type Error = SettingError;

    fn try_from(settings: &{name}) -> Result<Self, SettingError> {{
        Ok(Self {{
{to_core}        }})
    }}
}}
"
    );
    if defaults {
        let _ = write!(
            text,
            "
impl From<{core}> for {name} {{
    fn from(settings: {core}) -> Self {{
        Self {{
{to_c}        }}
    }}
}}
"
        );
    }
    Ok(text)
}

/// Field of a C struct.
struct Counterpart {
    name: String,
    /// Its type.
    c: &'static str,
    /// Makes the comment from the core's.
    note: fn(&str) -> String,
    /// Expressions that convert it.
    to_c: String,
    to_core: String,
}

fn counterpart(field: &Field) -> Result<Counterpart, String> {
    let name = field.ident.as_ref().map(ToString::to_string).unwrap_or_default();
    let Type::Path(kind) = &field.ty else { return Err(format!("{name}: not a plain type")) };
    let kind = kind.path.segments.last().map(|segment| segment.ident.to_string()).unwrap_or_default();
    let of = format!("settings.{name}");
    let (c, note, to_c, to_core): (_, fn(&str) -> String, _, _) = match kind.as_str() {
        "u8" => ("u8", same, of.clone(), of),
        "u16" => ("u16", same, of.clone(), of),
        "u32" => ("u32", same, of.clone(), of),
        "i32" => ("i32", same, of.clone(), of),
        "bool" => ("u8", flag, format!("{of}.into()"), format!("{of} != 0")),
        "Lines" => ("u8", lines, format!("{of}.bits()"), format!("Lines::from_bits_retain({of})")),
        "Amps" | "Celsius" | "ElectricalSpeed" | "Volts" => {
            ("i32", quantity, format!("{of}.to_bits()"), format!("{kind}::from_bits({of})"))
        }
        "Channel" => ("narx_channel_t", same, format!("{of}.into()"), format!("{of}.into()")),
        "Gain" => ("Gain", same, String::new(), format!("gain(\"{name}\", {of})?")),
        "CommutationSettings" => {
            let back = format!("(&{of}).try_into()?");
            ("narx_commutation_settings_t", same, format!("{of}.into()"), back)
        }
        _ => return Err(format!("{name}: {kind} has no counterpart in C")),
    };
    Ok(Counterpart { name, c, note, to_c, to_core })
}

fn same(text: &str) -> String {
    text.into()
}

fn flag(text: &str) -> String {
    let (first, rest) = text.split_at(1);
    format!("Not 0: {}{rest}", first.to_lowercase())
}

fn lines(text: &str) -> String {
    format!("{text} Sum of NARX_LINE_*.")
}

fn quantity(text: &str) -> String {
    format!("{text} Q16.")
}

/// Returns the text of a doc comment, on one line, in the words of C.
fn doc(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(literal) => match &literal.lit {
                Lit::Str(text) => Some(text.value().trim().to_owned()),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    });
    lines.collect::<Vec<_>>().join(" ").replace("raw I16F16", "Q16")
}

/// Renders a doc comment, within the width of code.
fn comment(indent: &str, text: &str) -> String {
    const WIDTH: usize = 110;
    let start = format!("{indent}///");
    let (mut rendered, mut line) = (String::new(), start.clone());
    for word in text.split(' ') {
        if line.len() + 1 + word.len() > WIDTH {
            rendered += &(line + "\n");
            line = start.clone();
        }
        line = line + " " + word;
    }
    rendered + &line + "\n"
}
