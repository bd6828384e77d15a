//! Errors of the standard classes of JavaScript: `TypeError`, `RangeError`, `Error`.

use core::fmt::Display;
use js_sys::{Error, Number, RangeError, TypeError};
use wasm_bindgen::JsValue;

/// Returns a `TypeError`: a value of a wrong type, or a name that does not exist.
pub fn type_error(message: &str) -> JsValue {
    TypeError::new(message).into()
}

/// Returns a `RangeError`: a value that the drive or the bench cannot have.
pub fn range_error(message: &dyn Display) -> JsValue {
    RangeError::new(&message.to_string()).into()
}

/// Returns an `Error`: an operation that failed.
pub fn error(message: &dyn Display) -> JsValue {
    Error::new(&message.to_string()).into()
}

/// Returns a value as its user wrote it; of anything but a text or a number the type. The engine formats
/// numbers, which saves the code of a formatter.
pub fn shown(value: &JsValue) -> String {
    if let Some(text) = value.as_string() {
        return format!("\"{text}\"");
    }
    let number = value.as_f64().and_then(|number| Number::from(number).to_string_with_radix(10).ok());
    let kind = || value.js_typeof().as_string().unwrap_or_default();
    number.map_or_else(kind, String::from)
}

/// Joins names: `a, b, c`.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut text = String::new();
    for name in names {
        if !text.is_empty() {
            text.push_str(", ");
        }
        text.push_str(name);
    }
    text
}

/// Checks that `value` is a whole number from `min` to `max`.
pub fn whole(what: &str, value: f64, min: f64, max: f64) -> Result<f64, JsValue> {
    if value.fract() == 0.0 && (min..=max).contains(&value) {
        return Ok(value);
    }
    let [value, min, max] = [value, min, max].map(|number| shown(&number.into()));
    Err(range_error(&format!("{what} {value}: must be a whole number from {min} to {max}")))
}
