//! `narx._core`: the control core and the bench for Python. This crate only converts types: all facts come
//! from core and sim. The package's Python files build the public interface on it.

mod bench;
mod blocks;
mod can_log;
mod coefficients;
mod description;
mod error;
mod experiment;
mod files;
mod frame;
mod identification;
mod log_record;
mod master;
mod motor;
mod notes;
mod plant;
mod recording;
mod server;
mod session;
mod state;
mod trace;
mod tx_driver;
mod tx_master;
mod virtual_bus;

/// The memory of a dropped column serves the next run: the kernel takes long for fresh pages.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// The compiled part of the package `narx`.
#[pyo3::pymodule]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::bench::{Bench, number};
    #[pymodule_export]
    use crate::blocks::{Commutation, Hall, HallReading, Pi, Ramp, ZeroCrossing, ZeroCrossingReading};
    #[pymodule_export]
    use crate::can_log::{LogReader, diagnostic_bits, fault_bits, frame_flags, frame_kinds};
    #[pymodule_export]
    use crate::coefficients::coefficients;
    #[pymodule_export]
    use crate::description::Description;
    #[pymodule_export]
    use crate::error::{checked_number, checked_whole_number};
    #[pymodule_export]
    use crate::experiment::{Experiment, experiment_figures, run_experiments};
    #[pymodule_export]
    use crate::files::{dbc, eds, xml};
    #[pymodule_export]
    use crate::frame::{decode, decode_node};
    #[pymodule_export]
    use crate::identification::Identification;
    #[pymodule_export]
    use crate::log_record::log_records;
    #[pymodule_export]
    use crate::master::Master;
    #[pymodule_export]
    use crate::motor::{Load, Motor, OperatingRange, SpeedLoop, restore_motor};
    #[pymodule_export]
    use crate::plant::Plant;
    #[pymodule_export]
    use crate::recording::{replay, scope_recording};
    #[pymodule_export]
    use crate::server::Server;
    #[pymodule_export]
    use crate::tx_master::{TxMaster, tx_objects};
    #[pymodule_export]
    use crate::virtual_bus::VirtualBus;

    #[pymodule_init]
    fn add_enumerations(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("COMMISSIONED", crate::motor::commissioned(module.py())?)?;
        module.add("NodeState", crate::tx_master::states(module.py())?)?;
        module.add("Step", crate::blocks::steps(module.py())?)?;
        module.add("State", crate::state::states(module.py())?)
    }
}
