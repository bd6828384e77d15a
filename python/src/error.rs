//! Errors of the classes in `narx.errors`, and checks of arguments. Every error names its subject, the value
//! and the allowed range.

use narx_core::bus::narmotion::ParameterStatus;
use narx_core::master::{DownloadError, Refusal, UpdateError};
use pyo3::prelude::*;
use pyo3::types::PyType;
use std::fmt::Display;

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

/// Checks that `name` is a finite number that `accepts` accepts; `allowed` describes the range in words.
pub(crate) fn number(
    name: &str,
    value: f64,
    unit: &str,
    allowed: &str,
    accepts: impl FnOnce(f64) -> bool,
) -> PyResult<f64> {
    if value.is_finite() && accepts(value) {
        return Ok(value);
    }
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    Err(parameter(format!("{name} {value}{unit}: must be {allowed}")))
}

/// Checks that `name` is a finite number.
pub(crate) fn finite(name: &str, value: f64, unit: &str) -> PyResult<f64> {
    number(name, value, unit, "a finite number", |_| true)
}

/// Checks that `name` is a finite number, 0 or more.
pub(crate) fn magnitude(name: &str, value: f64, unit: &str) -> PyResult<f64> {
    number(name, value, unit, "a finite number, 0 or more", |value| value >= 0.0)
}

/// Checks that `name` is a whole number within `min..=max`.
pub(crate) fn whole(name: &str, value: f64, unit: &str, min: f64, max: f64) -> PyResult<i64> {
    let allowed = format!("a whole number from {min} to {max}");
    number(name, value, unit, &allowed, |value| value.fract() == 0.0 && (min..=max).contains(&value))
        .map(|value| value as i64)
}

/// Returns the value of `name`, which must be one of the named choices.
pub(crate) fn choice<T: Copy>(name: &str, value: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let found = choices.iter().find(|(choice, _)| *choice == value);
    found.map(|(_, chosen)| *chosen).ok_or_else(|| {
        let names: Vec<&str> = choices.iter().map(|(choice, _)| *choice).collect();
        parameter(format!("{name} \"{value}\": must be one of {}", names.join(", ")))
    })
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
