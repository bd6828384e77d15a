//! The bench.

use crate::drive::Drive;
use crate::error;
use crate::motor::{self, Load, Motor};
use crate::session::Shared;
use crate::trace::Trace;
use narx_core::dictionary::Dictionary;
use narx_sim::session::Session;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyMapping};

/// A virtual drive with its motor on a simulated bench, commanded over its CAN bus. Same arguments and calls, same bits.
#[pyclass(module = "narx", frozen)]
pub(crate) struct Bench(Shared);

#[pymethods]
impl Bench {
    /// Commissions the drive for the motor and powers it up; it stays in Standby until `drive.start`.
    ///
    /// supply_voltage: V. mode: "sensorless", "hall" or "open-loop". parameters: of the drive by name or number, in their
    /// units; they win over those of commissioning. ambient: degrees Celsius. seed: of all noise.
    #[new]
    #[pyo3(signature = (motor, supply_voltage=48.0, load=None, mode="sensorless", parameters=None, ambient=25.0, seed=1))]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn new(
        motor: &Motor,
        supply_voltage: f64,
        load: Option<&Load>,
        mode: &str,
        parameters: Option<&Bound<'_, PyMapping>>,
        ambient: f64,
        seed: i128,
    ) -> PyResult<Self> {
        let mut config = motor.session(supply_voltage, motor::mode(mode)?);
        config.load = load.map_or(config.load, Load::config);
        config.parameters = parameters.map_or_else(|| Ok(Vec::new()), numbered)?;
        config.ambient = error::finite("ambient", ambient, "degrees Celsius")?;
        config.seed = u64::try_from(seed).map_err(|_| {
            error::parameter(format!("seed {seed}: must be a whole number from 0 to {}", u64::MAX))
        })?;
        Ok(Self(Shared::new(Session::new(&config).map_err(error::parameter)?)))
    }

    /// The drive on this bench.
    #[getter]
    fn drive(&self) -> Drive {
        Drive::new(self.0.clone())
    }

    /// Time since power-up, s.
    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        self.0.with(py, |session| session.bench().time())
    }

    /// Where a limit of the drive holds the motor back, in words.
    #[getter]
    fn notes(&self, py: Python<'_>) -> Vec<String> {
        self.0.with(py, |session| session.commissioning().notes.iter().map(ToString::to_string).collect())
    }

    /// Lets `seconds` pass, to the nearest control tick, and returns the rows of this run.
    fn run(&self, py: Python<'_>, seconds: f64) -> PyResult<Trace> {
        let seconds = error::magnitude("seconds", seconds, "s")?;
        let ticks = self.0.with(py, |session| {
            // Rows of calls that waited belong to no run.
            session.bench_mut().take_trace();
            (seconds * 1e9 / session.bench().period_ns() as f64).round() as u64
        });
        self.0.run_until(py, ticks, |_| false)?;
        let (table, recording) =
            self.0.with(py, |session| (session.bench_mut().take_trace(), session.bench().recording()));
        Trace::new(py, table, PyBytes::new(py, &recording))
    }
}

/// Parameters by number; a key that is a string is a name of the dictionary.
fn numbered(parameters: &Bound<'_, PyMapping>) -> PyResult<Vec<(u16, f64)>> {
    parameters
        .items()?
        .iter()
        .map(|item| {
            let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            let number = match key.extract::<String>() {
                Ok(name) => number(key.py(), &name)?,
                Err(_) => key.extract().map_err(|_| no_parameter(&key, ""))?,
            };
            let refused = |_| error::parameter(format!("parameter {key} {value}: must be a number"));
            Ok((number, value.extract().map_err(refused)?))
        })
        .collect()
}

fn number(py: Python<'_>, name: &str) -> PyResult<u16> {
    Dictionary::find(name).map(|row| row.number).ok_or_else(|| {
        let hint = error::suggestion(py, name, Dictionary::rows().map(|row| row.name));
        no_parameter(&format_args!("\"{name}\""), &hint)
    })
}

fn no_parameter(name: &dyn std::fmt::Display, hint: &str) -> PyErr {
    error::parameter(format!("there is no parameter {name}{hint}"))
}
