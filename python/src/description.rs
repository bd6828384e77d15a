//! Description of a drive: parameters, measurements and signals of the scope, with their scales.

use crate::error::{self, Given};
use crate::files;
use crate::frame;
use narx_core::bus::narmotion::Opcode;
use narx_core::bus::narmotion::ParameterStatus;
use narx_core::dictionary::engineering::{Misfit, Scale};
use narx_core::dictionary::{Decimal, Effect};
use narx_core::master::{
    Described, DescribedField, DescribedParameter, DescribedSignal, DescriptionError, DescriptionReader,
    Measurements, Received, Refusal,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, LazyLock};

/// The tables of a drive. Without a text they are those of this package.
#[pyclass(module = "narx._core", frozen)]
pub(crate) struct Description(Arc<Tables>);

/// Rows of a description.
#[derive(Default)]
pub(crate) struct Tables {
    parameters: Vec<Row>,
    /// Fields of the messages that the drive sends.
    fields: Vec<DescribedField>,
    signals: Vec<DescribedSignal>,
}

/// A parameter with its texts.
struct Row {
    row: DescribedParameter,
    category: String,
    about: String,
}

/// A signal of the measurements: name, unit, value and time of reception.
pub(crate) type Signal = (String, String, Option<(f64, f64)>);

static OWN: LazyLock<Arc<Tables>> = LazyLock::new(|| {
    // It is never empty: tests check that the description equals the tables.
    Arc::new(Tables::read(files::xml().as_bytes()).unwrap_or_default())
});

#[pymethods]
impl Description {
    #[new]
    #[pyo3(signature = (text=None))]
    fn new(text: Option<&[u8]>) -> PyResult<Self> {
        let Some(text) = text else { return Ok(Self(Arc::clone(&OWN))) };
        Tables::read(text).map(|tables| Self(Arc::new(tables))).map_err(error::refused)
    }

    /// Returns every parameter in the order of the document: a dictionary each, for `narx.parameters.Row`.
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.0.parameters.iter().map(|row| row.fields(py)).collect()
    }

    /// Returns the number of a parameter that is given by number or name; case does not matter.
    fn number(&self, key: &Bound<'_, PyAny>) -> PyResult<u16> {
        let Ok(name) = key.extract::<String>() else {
            let given: Given = key.extract()?;
            let number = given.whole().and_then(|number| u16::try_from(number).ok());
            let known = number.filter(|number| self.0.row(*number).is_some());
            return known.ok_or_else(|| error::parameter(format!("there is no parameter {key}")));
        };
        let mut rows = self.0.parameters.iter();
        rows.find(|row| row.row.name.eq_ignore_ascii_case(&name)).map(|row| row.row.number).ok_or_else(|| {
            let names = self.0.parameters.iter().map(|row| row.row.name.as_str());
            let hint = error::suggestion(key.py(), &name, names);
            error::parameter(format!("there is no parameter \"{name}\"{hint}"))
        })
    }

    /// Converts a parameter's value in its unit to its raw value, rounded to the nearest step of its scale.
    fn to_raw(&self, number: u16, value: &Bound<'_, PyAny>) -> PyResult<i64> {
        let row = self.0.known(number)?;
        let scale = Scale::from(row);
        scale.entered(entered(scale, value)?).map_err(error::parameter)
    }

    /// Converts a parameter's raw value to its unit; whole numbers stay whole. raw: its 32 bits, with or
    /// without sign extension.
    #[allow(clippy::wrong_self_convention, reason = "the converse of `to_raw`")]
    fn from_raw<'py>(&self, py: Python<'py>, number: u16, raw: i64) -> PyResult<Bound<'py, PyAny>> {
        let row = self.0.known(number)?;
        let raw = row.kind.widen(raw as i32);
        if row.exponent == 0 {
            return Ok(raw.into_pyobject(py)?.into_any());
        }
        Ok(Scale::from(row).to_unit(raw).into_pyobject(py)?.into_any())
    }

    /// Signals of the measurements: name, opcode, first word, unit, value of a raw 1.
    fn measurement_signals(&self) -> Vec<(String, u16, u8, String, f64)> {
        let scale = |exponent| frame::float(Decimal { digits: 1, exponent });
        let row = |row: &DescribedField| {
            (row.name.to_string(), row.opcode, row.first_bit / 16, row.unit.to_string(), scale(row.exponent))
        };
        self.0.signals_of_measurements().map(row).collect()
    }

    /// Signals of the virtual scope: bit, name, unit, value of a sample of 1.
    fn scope_signals(&self) -> Vec<(u8, String, String, f64)> {
        let rows = self.0.signals.iter();
        rows.map(|row| (row.bit, row.name.to_string(), row.unit.to_string(), frame::float(row.base)))
            .collect()
    }
}

impl Description {
    pub(crate) fn tables(&self) -> Arc<Tables> {
        Arc::clone(&self.0)
    }
}

impl Row {
    fn fields<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let Self { row, category, about } = self;
        let scale = Scale::from(row);
        let fields = PyDict::new(py);
        fields.set_item("number", row.number)?;
        fields.set_item("name", row.name.as_str())?;
        fields.set_item("category", category)?;
        fields.set_item("unit", row.unit.as_str())?;
        fields.set_item("type", row.kind.label())?;
        fields.set_item("scale", scale.to_unit(1))?;
        fields.set_item("min", scale.to_unit(row.min))?;
        fields.set_item("max", scale.to_unit(row.max))?;
        fields.set_item("factory", scale.to_unit(row.default))?;
        fields.set_item("access", row.access.label())?;
        fields.set_item("command", row.command)?;
        fields.set_item("acts", Effect::label(row.effect))?;
        fields.set_item("description", about)?;
        Ok(fields)
    }
}

impl Tables {
    /// Returns the tables of this package.
    pub(crate) fn own() -> Arc<Self> {
        Arc::clone(&OWN)
    }

    /// Reads a whole document.
    fn read(text: &[u8]) -> Result<Self, DescriptionError> {
        let mut reader = DescriptionReader::new();
        let (mut tables, mut categories) = (Self::default(), Vec::new());
        for (place, byte) in text.iter().enumerate() {
            match reader.handle_byte(*byte)? {
                Some(Described::Category(category)) => categories.push(category),
                Some(Described::Parameter(row)) => {
                    let named = categories.iter().find(|category| category.number == row.category);
                    let category = named.map_or_else(
                        || row.category.to_string(),
                        |category| format!("{}-{}", category.number, category.name),
                    );
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
        reader.finish()?;
        Ok(tables)
    }

    /// Returns the row with this number.
    pub(crate) fn row(&self, number: u16) -> Option<&DescribedParameter> {
        self.parameters.iter().map(|row| &row.row).find(|row| row.number == number)
    }

    fn known(&self, number: u16) -> PyResult<&DescribedParameter> {
        self.row(number).ok_or_else(|| error::parameter(format!("there is no parameter {number}")))
    }

    /// Returns every signal of the measurements; received ones with value and time in s.
    pub(crate) fn measurements(&self, received: &Measurements) -> Vec<Signal> {
        let signal = |field: &DescribedField| {
            let frame = Opcode::new(field.opcode).and_then(|opcode| received.frame(opcode));
            let value = frame
                .map(|Received { value, at }| (frame::float(field.value(value.encode())), at as f64 / 1e6));
            (field.name.to_string(), field.unit.to_string(), value)
        };
        self.signals_of_measurements().map(signal).collect()
    }

    fn signals_of_measurements(&self) -> impl Iterator<Item = &DescribedField> {
        let first = Opcode::MEASUREMENT_0.raw();
        self.fields.iter().filter(move |field| (first..first + 9).contains(&field.opcode))
    }

    /// Returns the error for a parameter that the drive does not read or write, with the description's name
    /// and range.
    pub(crate) fn refusal(&self, refusal: &Refusal) -> PyErr {
        let Some(row) = self.row(refusal.number) else { return error::refusal(refusal) };
        let scale = Scale::from(row);
        let message = match (refusal.status, refusal.offered) {
            (ParameterStatus::OutOfRange, Some(raw)) if !row.accepts(raw) => {
                Misfit { scale, value: scale.to_unit(row.kind.widen(raw)) }.to_string()
            }
            (status, _) => format!("{scale}: {status}"),
        };
        error::refused_parameter(refusal.status, message)
    }
}

/// Converts a number that a user has entered; anything else is an error.
pub(crate) fn entered(scale: Scale<'_>, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let given: Given = value.extract()?;
    given.real().ok_or_else(|| {
        let (kind, unit) = (if scale.is_whole() { "whole number" } else { "number" }, scale.unit);
        let space = if unit.is_empty() { "" } else { " " };
        let [min, max] = [scale.min, scale.max].map(|raw| scale.to_unit(raw));
        error::parameter(format!("{scale}: {given} is not a {kind} from {min} to {max}{space}{unit}"))
    })
}
