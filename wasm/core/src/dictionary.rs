//! Tables: parameters, signals of scope and measurements, and the values of log records.

use crate::description::{self, Shape};
use crate::messages::{float, unit};
use js_sys::{Array, Object};
use narx_core::bus::narmotion::{SIGNALS, Signal};
use narx_core::dictionary::engineering::Scale;
use narx_core::dictionary::{Decimal, Dictionary, Parameter};
use narx_core::storage::Record;
use narx_wasm_values::error::{list, shown, type_error};
use narx_wasm_values::options::set;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Properties of one parameter, without its value. Limits and factory value are in its unit. */
export interface Parameter {
    readonly number: number;
    readonly name: ParameterName;
    readonly category: string;
    /** Unit; empty for plain numbers. */
    readonly unit: string;
    readonly type: "uint16" | "int32" | "uint32";
    /** Value of a raw 1. */
    readonly scale: number;
    readonly min: number;
    readonly max: number;
    readonly factory: number;
    /** Write access of masters: never, while the drive is stopped, or at any time. */
    readonly access: "read-only" | "stopped" | "live";
    /** True for a command: writing 0, then 1 executes it. */
    readonly command: boolean;
    /** Time at which a written value takes effect. */
    readonly acts: "at once" | "next start" | "reboot";
    readonly description: string;
}

/** A signal of the virtual scope. */
export interface ScopeSignal {
    /** Bit of the signal in parameter 22. */
    readonly bit: number;
    readonly name: ScopeSignalName;
    readonly unit: string;
    /** Value of a sample of 4096. */
    readonly base: number;
}

/** A signal of the broadcast measurements. */
export interface MeasurementSignal {
    readonly name: MeasurementName;
    readonly unit: string;
    readonly opcode: number;
    /** Index of its word in the frame, 0 to 3. */
    readonly word: number;
    /** Value of a raw 1. */
    readonly scale: number;
}

/** A record of a log download. */
export interface LogRecord {
    readonly index: number;
    /** Time since power-up, s. */
    readonly time: number;
    /** Each value's source (the number in its slot, with the kind of kept value in bits 15 and 14), and its
     * raw number. */
    readonly values: readonly (readonly [what: number, raw: number])[];
}
"#;

/// Returns every parameter in the order of the numbers.
#[wasm_bindgen(unchecked_return_type = "Parameter[]")]
pub fn parameters() -> Array {
    Dictionary::rows().map(|row| object(&shape(row))).collect()
}

/// Returns the properties of a row of this package's tables.
pub(crate) fn shape(row: &'static Parameter) -> Shape<'static> {
    Shape {
        scale: row.into(),
        kind: row.kind,
        category: row.category.label(),
        default: row.default(),
        access: row.access,
        command: row.command,
        effect: row.effect,
        about: row.description(),
    }
}

pub(crate) fn object(row: &Shape<'_>) -> Object {
    let Scale { number, name, unit, min, max, .. } = row.scale;
    let value = |raw| row.scale.to_unit(raw);
    let shaped = Object::new();
    set(&shaped, "number", number);
    set(&shaped, "name", name);
    set(&shaped, "category", row.category);
    set(&shaped, "unit", unit);
    set(&shaped, "type", row.kind.label());
    set(&shaped, "scale", value(1));
    set(&shaped, "min", value(min));
    set(&shaped, "max", value(max));
    set(&shaped, "factory", value(row.default));
    set(&shaped, "access", row.access.label());
    set(&shaped, "command", row.command);
    set(&shaped, "acts", row.effect.label());
    set(&shaped, "description", row.about);
    shaped
}

/// Returns the row of a parameter that is given by number or name; case does not matter.
pub(crate) fn row(key: &JsValue) -> Result<&'static Parameter, JsValue> {
    let by_number = key.as_f64().filter(|number| number.fract() == 0.0 && (0.0..65_536.0).contains(number));
    let found = match key.as_string() {
        Some(name) => Dictionary::find(&name),
        None => by_number.and_then(|number| Dictionary::row(number as u16)),
    };
    found.ok_or_else(|| type_error(&format!("there is no parameter {}", shown(key))))
}

/// Returns the signals of the virtual scope in the order of their bits.
#[wasm_bindgen(js_name = scopeSignals, unchecked_return_type = "ScopeSignal[]")]
pub fn scope_signals() -> Array {
    description::scope_signals(None)
}

/// Returns the signals of the measurements in the order of Figure 14.
#[wasm_bindgen(js_name = measurementSignals, unchecked_return_type = "MeasurementSignal[]")]
pub fn measurement_signals() -> Array {
    let shape = |row: &Signal| {
        let scale = Decimal { digits: 1, exponent: row.exponent };
        measured(row.name, unit(row.unit), row.opcode.raw(), row.word, scale)
    };
    SIGNALS.iter().map(shape).collect()
}

pub(crate) fn measured(name: &str, unit: &str, opcode: u16, word: u8, scale: Decimal) -> Object {
    let shaped = Object::new();
    set(&shaped, "name", name);
    set(&shaped, "unit", unit);
    set(&shaped, "opcode", opcode);
    set(&shaped, "word", word);
    set(&shaped, "scale", float(scale));
    shaped
}

/// Decodes the records of a log download, each of `size` bytes (parameter 69); those that the drive could not
/// read are left out.
#[wasm_bindgen(js_name = logRecords, unchecked_return_type = "LogRecord[]")]
pub fn log_records(bytes: &[u8], size: usize) -> Array {
    let record = |bytes: &[u8]| {
        let record = Record::parse(bytes)?;
        let entry = record.entry();
        let pair = |(what, raw): &(u16, i32)| Array::of2(&(*what).into(), &(*raw).into());
        let shaped = Object::new();
        set(&shaped, "index", record.index());
        set(&shaped, "time", f64::from(entry.time) / 1000.0);
        set(&shaped, "values", entry.values.iter().map(pair).collect::<Array>());
        Some(shaped)
    };
    bytes.chunks_exact(size.max(1)).filter_map(record).collect()
}

/// Returns the value of `choices` with this name.
pub(crate) fn choice<T: Copy>(what: &str, given: &JsValue, choices: &[(&str, T)]) -> Result<T, JsValue> {
    let text = given.as_string();
    let found = choices.iter().find(|(name, _)| text.as_deref() == Some(name));
    found.map(|(_, chosen)| *chosen).ok_or_else(|| {
        let names = list(choices.iter().map(|(name, _)| *name));
        type_error(&format!("{what} {}: must be one of {names}", shown(given)))
    })
}
