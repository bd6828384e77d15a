//! The states of the drive as a Python enumeration, made from core's.

use narx_core::motor::State;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// `narx.State`: an `IntEnum` with the numbers of the specification (section 7).
pub(crate) fn enumeration(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let members: Vec<(String, u8)> =
        State::ALL.iter().map(|state| (words(state).to_uppercase(), *state as u8)).collect();
    let options = PyDict::new(py);
    options.set_item("module", "narx")?;
    py.import("enum")?.getattr("IntEnum")?.call(("State", members), Some(&options))
}

/// The member of `narx.State` for a state.
pub(crate) fn member(py: Python<'_>, state: State) -> PyResult<Bound<'_, PyAny>> {
    py.import("narx._core")?.getattr("State")?.call1((state as u8,))
}

/// The words of a Rust name: `RotorLock` is `rotor_lock`.
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
