//! Core's enumerations for Python, and the states of the drive.

use narx_core::motor::State;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Builds `narx.State`: an `IntEnum` with the numbers of the specification (section 7).
pub(crate) fn states(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let members = State::ALL.map(|state| (words(&state), state as u8));
    let doc = "States of the drive, with the numbers of the specification (section 7).";
    enumeration(py, "narx", "State", doc, &members)
}

/// Builds an `IntEnum`. Names become upper case.
pub(crate) fn enumeration<'py>(
    py: Python<'py>,
    module: &str,
    name: &str,
    doc: &str,
    members: &[(String, u8)],
) -> PyResult<Bound<'py, PyAny>> {
    let members: Vec<(String, u8)> =
        members.iter().map(|(name, number)| (name.to_uppercase(), *number)).collect();
    let options = PyDict::new(py);
    options.set_item("module", module)?;
    let class = py.import("enum")?.getattr("IntEnum")?.call((name, members), Some(&options))?;
    class.setattr("__doc__", doc)?;
    Ok(class)
}

/// Returns the member of `narx.State` for a state.
pub(crate) fn member(py: Python<'_>, state: State) -> PyResult<Bound<'_, PyAny>> {
    py.import("narx._core")?.getattr("State")?.call1((state as u8,))
}

/// Returns the words of a Rust name: `RotorLock` becomes `rotor_lock`.
pub(crate) fn words(name: &impl std::fmt::Debug) -> String {
    let mut words = String::new();
    for letter in format!("{name:?}").chars() {
        if letter.is_uppercase() && !words.is_empty() {
            words.push('_');
        }
        words.extend(letter.to_lowercase());
    }
    words
}
