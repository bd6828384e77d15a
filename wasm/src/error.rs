//! Errors of the kinds that JavaScript programmers expect: `TypeError`, `RangeError`, `Error`.

use core::fmt::Display;
use js_sys::{Error, JsString, RangeError, TypeError};
use wasm_bindgen::JsValue;

/// A value of another type than was asked for, or a name that does not exist.
pub(crate) fn type_error(message: &str) -> JsValue {
    TypeError::new(message).into()
}

/// A value that the drive or the bench cannot have.
pub(crate) fn range_error(message: &dyn Display) -> JsValue {
    RangeError::new(&message.to_string()).into()
}

/// What could not be done.
pub(crate) fn error(message: &dyn Display) -> JsValue {
    Error::new(&message.to_string()).into()
}

/// A value as its user wrote it: the engine formats numbers, which saves carrying a formatter.
pub(crate) fn shown(value: &JsValue) -> String {
    if value.is_object() && !value.is_function() && !js_sys::Array::is_array(value) {
        return "[object]".into();
    }
    match value.as_string() {
        Some(text) => format!("\"{text}\""),
        None => String::from(JsString::from(value.clone())),
    }
}

/// `a, b, c`
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    let mut text = String::new();
    for name in names {
        if !text.is_empty() {
            text.push_str(", ");
        }
        text.push_str(name);
    }
    text
}
