//! Errors of the classes in `narx.errors`, and arguments that are checked. Every refusal names what, its value and what
//! is allowed.

use narx_core::bus::narmotion::ParameterStatus;
use narx_core::master::{DownloadError, Refusal, UpdateError};
use pyo3::prelude::*;
use pyo3::types::PyType;
use std::fmt::Display;

/// An argument or a parameter of the drive that cannot have its value.
pub(crate) fn parameter(message: impl Display) -> PyErr {
    raise("ParameterError", &message)
}

/// Bytes that are not a recording, or not one that this version can replay.
pub(crate) fn recording(message: impl Display) -> PyErr {
    raise("RecordingError", &message)
}

/// The drive does not answer.
pub(crate) fn no_answer(message: impl Display) -> PyErr {
    raise("NoAnswerError", &message)
}

/// The drive, or this master, does not do what it is asked for now.
pub(crate) fn refused(message: impl Display) -> PyErr {
    raise("RefusedError", &message)
}

/// A node does not do what it is asked for: an SDO abort with its code.
pub(crate) fn abort(py: Python<'_>, message: String, code: u32) -> PyErr {
    let class = py.import("narx.errors").and_then(|module| module.getattr("AbortError"));
    match class.and_then(|class| class.call1((message, code))) {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// A parameter that the drive does not read or write.
pub(crate) fn refusal(refusal: &Refusal) -> PyErr {
    refused_parameter(refusal.status, refusal)
}

/// The same in other words.
pub(crate) fn refused_parameter(status: ParameterStatus, message: impl Display) -> PyErr {
    match status {
        ParameterStatus::WrongState | ParameterStatus::Storage | ParameterStatus::NotEquipped => {
            refused(message)
        }
        _ => parameter(message),
    }
}

/// A request that is done in another way than it was asked for. The caller of the caller of the method that has called is who asked.
pub(crate) fn warn(py: Python<'_>, class: &str, message: &str) -> PyResult<()> {
    let class = py.import("narx.errors")?.getattr(class)?;
    py.import("warnings")?.call_method1("warn", (message, class, 3))?;
    Ok(())
}

/// A file that is no image, or not one for this drive.
pub(crate) fn image(message: impl Display) -> PyErr {
    raise("ImageError", &message)
}

/// An update after which the drive runs what it ran before.
pub(crate) fn update(error: UpdateError) -> PyErr {
    match error {
        UpdateError::NoAnswer | UpdateError::Silent => no_answer(error),
        UpdateError::Hardware { .. } | UpdateError::TooLong { .. } | UpdateError::Older { .. } => {
            image(error)
        }
        _ => refused(error),
    }
}

/// A download that came to nothing.
pub(crate) fn download(error: DownloadError) -> PyErr {
    match error {
        DownloadError::NoAnswer => no_answer(error),
        DownloadError::Refused(refused) => refusal(&refused),
        _ => refused(error),
    }
}

/// `name` must be a finite number that `allowed` says in words and `accepts` decides.
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

/// `name` must be a finite number.
pub(crate) fn finite(name: &str, value: f64, unit: &str) -> PyResult<f64> {
    number(name, value, unit, "a finite number", |_| true)
}

/// `name` must be a finite number, 0 or more.
pub(crate) fn magnitude(name: &str, value: f64, unit: &str) -> PyResult<f64> {
    number(name, value, unit, "a finite number, 0 or more", |value| value >= 0.0)
}

/// `name` must be a whole number within `min..=max`.
pub(crate) fn whole(name: &str, value: f64, unit: &str, min: f64, max: f64) -> PyResult<i64> {
    let allowed = format!("a whole number from {min} to {max}");
    number(name, value, unit, &allowed, |value| value.fract() == 0.0 && (min..=max).contains(&value))
        .map(|value| value as i64)
}

/// `name` must be one of the named values.
pub(crate) fn choice<T: Copy>(name: &str, value: &str, choices: &[(&str, T)]) -> PyResult<T> {
    let found = choices.iter().find(|(choice, _)| *choice == value);
    found.map(|(_, chosen)| *chosen).ok_or_else(|| {
        let names: Vec<&str> = choices.iter().map(|(choice, _)| *choice).collect();
        parameter(format!("{name} \"{value}\": must be one of {}", names.join(", ")))
    })
}

/// `, did you mean "x"?` for the names that look most like `wanted`.
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
