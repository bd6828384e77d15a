//! `narx._core`: the control core and the bench for Python. Types are converted here; every fact comes from core and sim.

mod bench;
mod drive;
mod error;
mod motor;
mod recording;
mod session;
mod state;
mod trace;

/// The compiled part of the package `narx`.
#[pyo3::pymodule]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::bench::Bench;
    #[pymodule_export]
    use crate::drive::Drive;
    #[pymodule_export]
    use crate::motor::{Load, Motor};
    #[pymodule_export]
    use crate::recording::{Replay, replay};
    #[pymodule_export]
    use crate::trace::Trace;

    #[pymodule_init]
    fn add_enumerations(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("State", crate::state::enumeration(module.py())?)
    }
}
