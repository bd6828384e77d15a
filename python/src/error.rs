//! Errors of the classes in `narx.errors`, and the checks of all arguments. Every error names its subject,
//! the value and the allowed range.

use narx_core::bus::narmotion::ParameterStatus;
use narx_core::master::{DownloadError, Refusal, UpdateError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyFloat, PyMapping, PyString, PyType};
use std::fmt::{self, Display};

/// Returns a ParameterError: an argument or a parameter of the drive is invalid.
pub(crate) fn parameter(message: impl Display) -> PyErr {
    raise("ParameterError", &message)
}

/// Returns a RecordingError: the bytes are not a recording, or not one that this version can replay.
pub(crate) fn recording(message: impl Display) -> PyErr {
    raise("RecordingError", &message)
}

/// Returns a NoAnswerError: the drive does not answer.
pub(crate) fn no_answer(message: impl Display) -> PyErr {
    raise("NoAnswerError", &message)
}

/// Returns a RefusedError: the drive, or this master, refuses the request now.
pub(crate) fn refused(message: impl Display) -> PyErr {
    raise("RefusedError", &message)
}

/// Returns a StartError: the motor did not start, or was not calibrated.
pub(crate) fn start(message: impl Display) -> PyErr {
    raise("StartError", &message)
}

/// Returns an AbortError: a node refuses a request, with the code of its SDO abort.
pub(crate) fn abort(py: Python<'_>, message: String, code: u32) -> PyErr {
    let class = py.import("narx.errors").and_then(|module| module.getattr("AbortError"));
    match class.and_then(|class| class.call1((message, code))) {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// Returns the error for a parameter that the drive does not read or write.
pub(crate) fn refusal(refusal: &Refusal) -> PyErr {
    refused_parameter(refusal.status, refusal)
}

/// Returns the error for a parameter that the drive does not read or write, with another message.
pub(crate) fn refused_parameter(status: ParameterStatus, message: impl Display) -> PyErr {
    match status {
        ParameterStatus::WrongState | ParameterStatus::Storage | ParameterStatus::NotEquipped => {
            refused(message)
        }
        _ => parameter(message),
    }
}

/// Warns that a request is carried out in another way than requested. The warning is attributed to the caller
/// of the Python function that has called the compiled method.
pub(crate) fn warn(py: Python<'_>, class: &str, message: &str) -> PyResult<()> {
    let class = py.import("narx.errors")?.getattr(class)?;
    py.import("warnings")?.call_method1("warn", (message, class, 3))?;
    Ok(())
}

/// Returns an ImageError: the file is no image, or not one for this drive.
pub(crate) fn image(message: impl Display) -> PyErr {
    raise("ImageError", &message)
}

/// Converts the error of an update, after which the drive runs its previous image.
pub(crate) fn update(error: UpdateError) -> PyErr {
    match error {
        UpdateError::NoAnswer | UpdateError::Silent => no_answer(error),
        UpdateError::Hardware { .. } | UpdateError::TooLong { .. } | UpdateError::Older { .. } => {
            image(error)
        }
        _ => refused(error),
    }
}

/// Converts the error of a download.
pub(crate) fn download(error: DownloadError) -> PyErr {
    match error {
        DownloadError::NoAnswer => no_answer(error),
        DownloadError::Refused(refused) => refusal(&refused),
        _ => refused(error),
    }
}

/// A value as the user has given it: every number and word of a call is one, so that only the functions below
/// decide what it may be.
#[derive(Clone, Debug)]
pub(crate) enum Given {
    Whole(i128),
    Real(f64),
    Word(String),
    /// Anything else, as Python shows it: a bool, bytes, a whole number of more than 128 bits.
    Other(String),
}

/// Number of characters that an error shows of a value.
const SHOWN: usize = 40;

impl FromPyObject<'_, '_> for Given {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        if let Ok(word) = value.cast::<PyString>() {
            return Ok(Self::Word(word.to_string_lossy().into_owned()));
        }
        if let Ok(real) = value.cast::<PyFloat>() {
            return Ok(Self::Real(real.value()));
        }
        if !is_truth(&value) {
            if let Ok(whole) = value.extract() {
                return Ok(Self::Whole(whole));
            }
            if let Ok(real) = value.extract() {
                return Ok(Self::Real(real));
            }
        }
        let shown = value.repr().map_or_else(|_| value.get_type().to_string(), |shown| shown.to_string());
        Ok(Self::Other(shown))
    }
}

impl Given {
    pub(crate) fn word(word: &str) -> Self {
        Self::Word(word.into())
    }

    pub(crate) fn real(&self) -> Option<f64> {
        match *self {
            Self::Whole(value) => Some(value as f64),
            Self::Real(value) => Some(value),
            Self::Word(_) | Self::Other(_) => None,
        }
    }

    pub(crate) fn whole(&self) -> Option<i128> {
        match *self {
            Self::Whole(value) => Some(value),
            Self::Real(value) if value.fract() == 0.0 => Some(value as i128),
            _ => None,
        }
    }

    /// Returns the error for this value of `name`.
    fn refused(&self, name: &str, unit: &str, allowed: &str) -> PyErr {
        let unit = self.real().map_or_else(String::new, |_| spaced(unit));
        parameter(format!("{name} {self}{unit}: must be {allowed}"))
    }
}

/// Returns a unit as it stands after a number.
fn spaced(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" {unit}") }
}

impl Display for Given {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole(value) => value.fmt(f),
            Self::Real(value) if value.abs() >= 1e16 && value.is_finite() => write!(f, "{value:e}"),
            Self::Real(value) => value.fmt(f),
            Self::Word(word) => write!(f, "'{word}'"),
            Self::Other(shown) if shown.chars().count() > SHOWN => {
                let begin: String = shown.chars().take(SHOWN).collect();
                write!(f, "{begin}...")
            }
            Self::Other(shown) => f.write_str(shown),
        }
    }
}

impl From<f64> for Given {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}

impl From<u8> for Given {
    fn from(value: u8) -> Self {
        Self::Whole(value.into())
    }
}

impl From<&str> for Given {
    fn from(word: &str) -> Self {
        Self::word(word)
    }
}

/// Returns whether the value is a bool of Python or of numpy.
fn is_truth(value: &Bound<'_, PyAny>) -> bool {
    let name = value.get_type().name();
    value.is_instance_of::<PyBool>() || name.is_ok_and(|name| name == "bool_" || name == "bool")
}

/// Checks that `name` is a finite number that `accepts` accepts; `allowed` describes the range in words.
pub(crate) fn number(
    name: &str,
    given: impl Into<Given>,
    unit: &str,
    allowed: &str,
    accepts: impl FnOnce(f64) -> bool,
) -> PyResult<f64> {
    let given = given.into();
    let found = given.real().filter(|value| value.is_finite() && accepts(*value));
    found.ok_or_else(|| given.refused(name, unit, allowed))
}

/// Checks that `name` is a finite number.
pub(crate) fn finite(name: &str, given: impl Into<Given>, unit: &str) -> PyResult<f64> {
    number(name, given, unit, "a finite number", |_| true)
}

/// Checks that `name` is a finite number, 0 or more.
pub(crate) fn magnitude(name: &str, given: impl Into<Given>, unit: &str) -> PyResult<f64> {
    number(name, given, unit, "a finite number, 0 or more", |value| value >= 0.0)
}

/// Checks that `name` is a number within `min..=max`.
pub(crate) fn within(name: &str, given: impl Into<Given>, unit: &str, min: f64, max: f64) -> PyResult<f64> {
    let allowed = format!("a number from {min} to {max}{}", spaced(unit));
    number(name, given, unit, &allowed, |value| (min..=max).contains(&value))
}

/// Checks that `name` is a whole number within `min..=max`.
pub(crate) fn whole<T>(name: &str, given: impl Into<Given>, unit: &str, min: T, max: T) -> PyResult<T>
where
    T: TryFrom<i128> + Into<i128> + Copy + Display,
{
    let given = given.into();
    let found = given.whole().filter(|value| (min.into()..=max.into()).contains(value));
    found.and_then(|value| T::try_from(value).ok()).ok_or_else(|| {
        given.refused(name, unit, &format!("a whole number from {min} to {max}{}", spaced(unit)))
    })
}

/// Checks that `name` is True or False.
pub(crate) fn flag(name: &str, value: &Bound<'_, PyAny>) -> PyResult<bool> {
    value.extract().map_err(|_| parameter(format!("{name} {}: must be True or False", shown(value))))
}

/// Checks that `name` is a mapping of names or numbers to values.
pub(crate) fn mapping<'a, 'py>(
    name: &str,
    value: &'a Bound<'py, PyAny>,
) -> PyResult<&'a Bound<'py, PyMapping>> {
    let refused = || parameter(format!("{name} {}: must be a mapping of names to values", shown(value)));
    value.cast::<PyMapping>().map_err(|_| refused())
}

fn shown(value: &Bound<'_, PyAny>) -> String {
    value.extract::<Given>().map_or_else(|_| String::new(), |given| given.to_string())
}

/// Returns the value of `name`, which must be one of the named choices.
pub(crate) fn choice<T: Copy>(name: &str, given: impl Into<Given>, choices: &[(&str, T)]) -> PyResult<T> {
    let given = given.into();
    let shown = match &given {
        Given::Word(word) => match choices.iter().find(|(choice, _)| choice == word) {
            Some((_, chosen)) => return Ok(*chosen),
            None => format!("\"{word}\""),
        },
        other => other.to_string(),
    };
    let names: Vec<&str> = choices.iter().map(|(choice, _)| *choice).collect();
    Err(parameter(format!("{name} {shown}: must be one of {}", names.join(", "))))
}

/// Returns a finite number of a user's: `min` or more, and at most `max`. Raises ParameterError.
#[pyfunction]
#[pyo3(name = "number", signature = (name, value, unit="", min=None, max=None))]
pub(crate) fn checked_number(
    name: &str,
    value: Given,
    unit: &str,
    min: Option<f64>,
    max: Option<f64>,
) -> PyResult<f64> {
    match (min, max) {
        (Some(min), Some(max)) => within(name, value, unit, min, max),
        (Some(min), None) => {
            let allowed = format!("a finite number, {min} or more");
            number(name, value, unit, &allowed, |value| value >= min)
        }
        _ => finite(name, value, unit),
    }
}

/// Returns a whole number of a user's from `min` to `max`. Raises ParameterError.
#[pyfunction]
#[pyo3(name = "whole_number", signature = (name, value, min, max=None, unit=""))]
pub(crate) fn checked_whole_number(
    name: &str,
    value: Given,
    min: i128,
    max: Option<i128>,
    unit: &str,
) -> PyResult<i128> {
    match max {
        Some(max) => whole(name, value, unit, min, max),
        None => {
            let found = value.whole().filter(|value| *value >= min);
            found.ok_or_else(|| value.refused(name, unit, &format!("a whole number, {min} or more")))
        }
    }
}

/// Returns `; did you mean "x"?` for the names that are most similar to `wanted`.
pub(crate) fn suggestion<'a>(py: Python<'_>, wanted: &str, names: impl Iterator<Item = &'a str>) -> String {
    let names: Vec<&str> = names.collect();
    let close = || -> PyResult<Vec<String>> {
        py.import("difflib")?.call_method1("get_close_matches", (wanted, names))?.extract()
    };
    match close() {
        Ok(close) if !close.is_empty() => format!("; did you mean \"{}\"?", close.join("\" or \"")),
        _ => String::new(),
    }
}

fn raise(class: &str, message: &dyn Display) -> PyErr {
    Python::attach(|py| {
        let found = py.import("narx.errors").and_then(|module| module.getattr(class));
        match found.and_then(|class| Ok(class.cast_into::<PyType>()?)) {
            Ok(class) => PyErr::from_type(class, (message.to_string(),)),
            Err(error) => error,
        }
    })
}
