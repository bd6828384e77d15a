//! Description of a drive, from the text that the drive itself serves: parameters, measurements and signals
//! of the scope. Without it the tables of this package are used.

use crate::dictionary;
use crate::messages::{float, unit};
use js_sys::{Array, Object};
use narx_core::bus::narmotion::{Opcode, Signal};
use narx_core::description::Measure;
use narx_core::dictionary::engineering::Scale;
use narx_core::dictionary::{Access, Decimal, Dictionary, Effect, Kind};
use narx_core::master::{
    Described, DescribedField, DescribedParameter, DescribedSignal, DescriptionReader, Measurements, Received,
};
use narx_core::motor::signal::DRIVE_SIGNALS;
use narx_wasm_values::error::{error, shown, type_error};
use narx_wasm_values::options::set;
use std::fmt::Write;
use wasm_bindgen::JsValue;

/// Rows of a description.
#[derive(Debug, Default)]
pub(crate) struct Tables {
    parameters: Vec<Row>,
    /// Fields of the messages that the drive sends.
    fields: Vec<DescribedField>,
    signals: Vec<DescribedSignal>,
}

/// A parameter with its texts.
#[derive(Debug)]
struct Row {
    row: DescribedParameter,
    category: String,
    about: String,
}

/// Properties of a parameter, from either table.
pub(crate) struct Shape<'a> {
    pub(crate) scale: Scale<'a>,
    pub(crate) kind: Kind,
    pub(crate) category: &'a str,
    pub(crate) default: i64,
    pub(crate) access: Access,
    pub(crate) command: bool,
    pub(crate) effect: Effect,
    pub(crate) about: &'a str,
}

impl Tables {
    /// Reads a whole document. `check` is the CRC-32 that the drive reports for it; 0 if the drive reports
    /// none.
    pub(crate) fn read(text: &[u8], check: u32) -> Result<Self, JsValue> {
        let (mut reader, mut measure) = (DescriptionReader::new(), Measure::default());
        let (mut tables, mut categories) = (Self::default(), Vec::new());
        // Counting does not fail. Bytes that are no text fail the CRC check.
        let _ = measure.write_str(core::str::from_utf8(text).unwrap_or_default());
        if check != 0 && measure.check() != check {
            return Err(error(&"description: its CRC differs from the one that the drive reports"));
        }
        for (place, byte) in text.iter().enumerate() {
            match reader.handle_byte(*byte).map_err(|refused| error(&refused))? {
                Some(Described::Category(category)) => categories.push(category),
                Some(Described::Parameter(row)) => {
                    let named = categories.iter().find(|category| category.number == row.category);
                    let mut category = row.category.as_str().to_owned();
                    if let Some(named) = named {
                        category.push('-');
                        category.push_str(&named.name);
                    }
                    // The text is between the tag and the next one.
                    let about = text.get(place + 1..).unwrap_or_default();
                    let about = about.split(|byte| *byte == b'<').next().unwrap_or_default();
                    let about = String::from_utf8_lossy(about).into_owned();
                    tables.parameters.push(Row { row, category, about });
                }
                Some(Described::Field(field)) if field.from_drive => tables.fields.push(field),
                Some(Described::Signal(signal)) => tables.signals.push(signal),
                Some(Described::Field(_)) | None => {}
            }
        }
        reader.finish().map_err(|refused| error(&refused))?;
        Ok(tables)
    }

    fn measured(&self) -> impl Iterator<Item = &DescribedField> {
        let first = Opcode::MEASUREMENT_0.raw();
        self.fields.iter().filter(move |field| (first..first + 9).contains(&field.opcode))
    }
}

impl Row {
    fn shape(&self) -> Shape<'_> {
        let Self { row, category, about } = self;
        let DescribedParameter { kind, default, access, command, effect, .. } = *row;
        Shape { scale: row.into(), kind, category, default, access, command, effect, about }
    }
}

/// Returns the row with this number.
pub(crate) fn shape(tables: Option<&Tables>, number: u16) -> Option<Shape<'_>> {
    match tables {
        Some(tables) => tables.parameters.iter().find(|row| row.row.number == number).map(Row::shape),
        None => Dictionary::row(number).map(dictionary::shape),
    }
}

/// Returns the number of a parameter that is given by number or name; case does not matter.
pub(crate) fn number(tables: Option<&Tables>, key: &JsValue) -> Result<u16, JsValue> {
    let Some(tables) = tables else { return dictionary::row(key).map(|row| row.number) };
    let (name, number) = (key.as_string(), key.as_f64());
    let same = |row: &&Row| match &name {
        Some(name) => row.row.name.eq_ignore_ascii_case(name),
        None => number == Some(row.row.number.into()),
    };
    let found = tables.parameters.iter().find(same);
    found
        .map(|row| row.row.number)
        .ok_or_else(|| type_error(&format!("there is no parameter {}", shown(key))))
}

/// Returns every parameter, as `Parameter`.
pub(crate) fn parameters(tables: Option<&Tables>) -> Array {
    match tables {
        Some(tables) => tables.parameters.iter().map(|row| dictionary::object(&row.shape())).collect(),
        None => dictionary::parameters(),
    }
}

/// Returns every signal of the scope, as `ScopeSignal`.
pub(crate) fn scope_signals(tables: Option<&Tables>) -> Array {
    let shape = |bit, name: &str, unit: &str, base| {
        let shaped = Object::new();
        set(&shaped, "bit", bit);
        set(&shaped, "name", name);
        set(&shaped, "unit", unit);
        set(&shaped, "base", float(base));
        shaped
    };
    match tables {
        Some(tables) => {
            let rows = tables.signals.iter();
            rows.map(|row| shape(row.bit, &row.name, &row.unit, row.base)).collect()
        }
        None => {
            let rows = (0..).zip(DRIVE_SIGNALS.iter());
            rows.map(|(bit, row)| shape(bit, row.name, unit(row.unit), row.base)).collect()
        }
    }
}

/// Returns every signal of the measurements, as `MeasurementSignal`.
pub(crate) fn measurement_signals(tables: Option<&Tables>) -> Array {
    let Some(tables) = tables else { return dictionary::measurement_signals() };
    tables
        .measured()
        .map(|row| {
            dictionary::measured(
                &row.name,
                &row.unit,
                row.opcode,
                row.first_bit / 16,
                Decimal { digits: 1, exponent: row.exponent },
            )
        })
        .collect()
}

/// Returns every measurement that was received, as `Measurement`.
pub(crate) fn measurements(tables: Option<&Tables>, received: &Measurements) -> Array {
    let shape = |name: &str, unit: &str, value, at| {
        let shaped = Object::new();
        set(&shaped, "name", name);
        set(&shaped, "unit", unit);
        set(&shaped, "value", float(value));
        set(&shaped, "time", crate::master::seconds(at));
        shaped
    };
    match tables {
        Some(tables) => {
            let field = |row: &DescribedField| {
                let Received { value, at } = received.frame(Opcode::new(row.opcode)?)?;
                Some(shape(&row.name, &row.unit, row.value(value.encode()), at))
            };
            tables.measured().filter_map(field).collect()
        }
        None => {
            let signal = |(row, received): (&Signal, Option<Received<_>>)| {
                let Received { value, at } = received?;
                Some(shape(row.name, unit(row.unit), value, at))
            };
            received.iter().filter_map(signal).collect()
        }
    }
}
