//! The bench.

use crate::description;
use crate::error::{self, Given};
use crate::master::Master;
use crate::motor::{self, Load, Motor};
use crate::notes;
use crate::session::Shared;
use crate::state::words;
use crate::trace;
use crate::tx_driver;
use crate::tx_master::TxMaster;
use narx_core::dictionary::Dictionary;
use narx_core::motor::Board;
use narx_host::fmu::{self, Variable};
use narx_sim::bench::SIGNALS;
use narx_sim::plant::{Injection, InjectionError, InjectionOptions, Input, Phase};
use narx_sim::session::{Session, SessionConfig, parse_board};
use narx_sim::trace::Trace;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use std::num::NonZeroU32;

/// A virtual drive with its motor on a simulated bench, and a master on its bus; the compiled part of
/// `narx.Bench`.
#[pyclass(module = "narx._core", frozen)]
pub(crate) struct Bench {
    session: Shared,
    /// Configuration at power-up.
    config: SessionConfig,
    /// Largest temperature that the winding may have, degrees Celsius.
    winding_max: f64,
}

/// Largest resistance of a supply, ohm.
const RESISTANCE_MAX: f64 = 100.0;

/// Most ticks from one row to the next.
const EVERY_MAX: u32 = 1_000_000;

/// Columns by name, and units by name.
type Rows<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>);

/// A model of FMI: its file, the file's token, its variables.
type Model = (String, String, Vec<(u32, &'static str, &'static str, String, String, f64)>);

/// Result of a run: columns by name, units by name, and the recording.
pub(crate) type Run<'py> = (Bound<'py, PyDict>, Bound<'py, PyDict>, Bound<'py, PyBytes>);

impl Bench {
    /// Control ticks of a time.
    fn ticks(&self, py: Python<'_>, seconds: Given) -> PyResult<u64> {
        let seconds = error::magnitude("seconds", seconds, "s")?;
        let rate = self.session.with(py, |session| session.bench().node().board().tick_rate);
        Ok((seconds * f64::from(rate)).round() as u64)
    }
}

#[pymethods]
impl Bench {
    #[new]
    #[pyo3(signature = (motor, supply_voltage=Given::Real(48.0), load=None, mode=Given::word("sensorless"), parameters=None,
                        ambient=Given::Real(25.0), seed=Given::Whole(1), pwm_rate=Given::Whole(10_000), recording=true))]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn new(
        motor: &Motor,
        supply_voltage: Given,
        load: Option<&Load>,
        mode: Given,
        parameters: Option<&Bound<'_, PyAny>>,
        ambient: Given,
        seed: Given,
        pwm_rate: Given,
        recording: bool,
    ) -> PyResult<Self> {
        let mut config = config(motor, supply_voltage, load, mode, parameters, ambient, seed, pwm_rate)?;
        config.trace = false;
        let session = Session::new(&config).map_err(error::parameter)?;
        let session = Shared::new(if recording { session } else { session.without_recording() });
        Ok(Self { session, config, winding_max: motor.max_winding_temperature() })
    }

    /// The master on this bench's bus.
    #[getter]
    fn master(&self) -> Master {
        Master::of_bench(self.session.clone())
    }

    /// Time since power-up, s.
    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        self.session.with(py, |session| session.bench().time())
    }

    /// Digest of all outputs of the drive since it last booted.
    #[getter]
    fn digest(&self, py: Python<'_>) -> u64 {
        self.session.with(py, |session| session.bench().digest())
    }

    /// Limits of the drive that restrict this motor, a sentence each; and whether the winding has been too
    /// hot.
    #[getter]
    fn notes(&self, py: Python<'_>) -> Vec<String> {
        let own = self.session.with(py, |session| notes::notes(session.commissioning()));
        let (hottest, time) = self.session.hottest(py);
        own.into_iter().chain(notes::winding(hottest, time, self.winding_max)).collect()
    }

    /// Runs the simulation for `seconds`, to the nearest control tick.
    fn advance(&self, py: Python<'_>, seconds: Given) -> PyResult<()> {
        let ticks = self.ticks(py, seconds)?;
        self.session.run(py, ticks)
    }

    /// Names and units of the signals that rows can have.
    #[staticmethod]
    fn signals() -> Vec<(&'static str, &'static str)> {
        SIGNALS.iter().map(|signal| (signal.name, signal.unit)).collect()
    }

    /// Keeps a row of one in `every` ticks from now on, with the signals at these places of `signals`;
    /// forgets the rows so far.
    fn keep_rows(&self, py: Python<'_>, places: Vec<usize>, every: Given) -> PyResult<()> {
        let every: u32 = error::whole("every", every, "", 1, EVERY_MAX)?;
        let every = NonZeroU32::new(every).unwrap_or(NonZeroU32::MIN);
        match self.session.with(py, |session| session.bench_mut().set_trace_of(&places, every)) {
            true => Ok(()),
            false => Err(error::parameter(format!("places {places:?}: must be below {}", SIGNALS.len()))),
        }
    }

    /// Makes room for the rows of the next `seconds`.
    fn reserve_rows(&self, py: Python<'_>, seconds: Given) -> PyResult<()> {
        let ticks = self.ticks(py, seconds)?;
        self.session.with(py, |session| session.bench_mut().reserve_trace(ticks));
        Ok(())
    }

    /// Keeps no rows from now on; forgets those so far.
    fn keep_no_rows(&self, py: Python<'_>) {
        self.session.with(py, |session| session.bench_mut().set_trace(false));
    }

    /// Returns columns and units, by name, of the rows since the previous call.
    fn take_rows<'py>(&self, py: Python<'py>) -> PyResult<Rows<'py>> {
        let taken = self.session.with(py, |session| session.bench_mut().take_trace());
        trace::columns(py, taken)
    }

    /// Recording since the drive booted.
    fn recording<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.session.with(py, |session| session.bench().recording()))
    }

    /// Returns this bench at power-up as a model of FMI: its file, the file's token, and its variables (value
    /// reference, name, unit, causality, kind, first value).
    fn fmu(&self) -> Model {
        let file = fmu::written(&self.config);
        let token = fmu::token(&file);
        let variables = fmu::variables(&self.config).into_iter().map(|variable| {
            let Variable { reference, name, unit, causality, kind, start } = variable;
            (reference, name, unit, words(&causality), words(&kind), start)
        });
        (file, token, variables.collect())
    }

    /// Returns a copy of the bench as it stands.
    fn copy(&self, py: Python<'_>) -> Self {
        Self { session: self.session.copy(py), config: self.config.clone(), winding_max: self.winding_max }
    }

    /// Injects a fault, or removes it (`active` false). `fault` is a name of `faults`.
    fn set_fault(
        &self,
        py: Python<'_>,
        fault: &str,
        active: bool,
        value: Option<Given>,
        phase: Option<Given>,
        high: &Bound<'_, PyAny>,
    ) -> PyResult<()> {
        let high = error::flag("high", high)?;
        let value = if active { value } else { Some(Injection::some_value(fault).into()) };
        let injection = injection(py, fault, value, phase, high)?;
        self.session.with(py, |session| {
            let plant = session.bench_mut().plant_mut();
            if active { plant.inject(injection) } else { plant.clear(injection) }
        });
        Ok(())
    }

    /// Names of the faults that can be injected.
    #[staticmethod]
    fn faults() -> Vec<&'static str> {
        Injection::NAMES.to_vec()
    }

    /// Removes all faults.
    fn clear_faults(&self, py: Python<'_>) {
        self.session.with(py, |session| session.bench_mut().plant_mut().clear_all());
    }

    /// Replaces the load.
    fn set_load(&self, py: Python<'_>, load: &Load) {
        let config = load.config();
        self.session.with(py, |session| session.bench_mut().plant_mut().set_load(config));
    }

    /// Changes the supply; what is not given stays. voltage: V. resistance: ohm. may_sink: takes current
    /// back.
    #[pyo3(signature = (voltage=None, resistance=None, may_sink=None))]
    fn set_supply(
        &self,
        py: Python<'_>,
        voltage: Option<Given>,
        resistance: Option<Given>,
        may_sink: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let voltage =
            voltage.map(|volts| error::within("voltage", volts, "V", 0.0, motor::VOLTAGE_MAX)).transpose()?;
        let resistance = resistance
            .map(|ohms| error::within("resistance", ohms, "ohm", 0.0, RESISTANCE_MAX))
            .transpose()?;
        let may_sink = may_sink.map(|value| error::flag("may_sink", value)).transpose()?;
        self.session.with(py, |session| {
            let plant = session.bench_mut().plant_mut();
            let mut supply = plant.config().supply;
            supply.voltage = voltage.unwrap_or(supply.voltage);
            supply.resistance = resistance.unwrap_or(supply.resistance);
            supply.may_sink = may_sink.unwrap_or(supply.may_sink);
            plant.set_supply(supply);
        });
        Ok(())
    }

    /// Sets an input of the board to a value; `input` is a name of `inputs`.
    fn set_input(&self, py: Python<'_>, input: Given, value: Given) -> PyResult<()> {
        let value = error::finite("value", value, "")?;
        let input = error::choice("input", input, &Input::ALL.map(|input| (input.name(), input)))?;
        let set = self.session.with(py, |session| session.bench_mut().plant_mut().set_input(input, value));
        set.map_err(|refused| error::parameter(format!("input {value}: {refused}")))
    }

    /// Names of the board's inputs.
    #[staticmethod]
    fn inputs() -> Vec<&'static str> {
        Input::ALL.map(Input::name).to_vec()
    }

    /// Powers up a TX-Driver on this bus and shaft. encoder: counts per revolution of an encoder on the
    /// shaft. measuring_range: mm.
    fn add_tx_driver(
        &self,
        py: Python<'_>,
        node_id: Given,
        channels: Given,
        encoder: Option<Given>,
        measuring_range: Given,
    ) -> PyResult<()> {
        let config = tx_driver::config(node_id, channels, encoder, measuring_range)?;
        self.session
            .with(py, |session| {
                let bench = session.bench_mut();
                let node = config.configuration.node();
                if bench.tx_drivers().iter().any(|device| device.driver().node() == node) {
                    let node_id = node.raw();
                    return Err(format!("node_id {node_id}: there is a TX-Driver of this node-id already"));
                }
                bench.add_tx_driver(&config).map(drop).map_err(|error| error.to_string())
            })
            .map_err(error::parameter)
    }

    /// Returns a master of a TX-Driver on this bench's bus. timeout: s.
    #[pyo3(signature = (node_id, channels, timeout))]
    fn tx_master(
        &self,
        py: Python<'_>,
        node_id: Given,
        channels: Given,
        timeout: Given,
    ) -> PyResult<TxMaster> {
        let master = TxMaster::with_station(node_id, channels, timeout)?;
        self.session.seat(py, &master.station());
        Ok(master)
    }
}

/// Converts a trace and a recording for Python.
pub(crate) fn run(py: Python<'_>, (table, recording): (Trace, Vec<u8>)) -> PyResult<Run<'_>> {
    let (columns, units) = trace::columns(py, table)?;
    Ok((columns, units, PyBytes::new(py, &recording)))
}

/// Returns a fault by its name in `faults`.
pub(crate) fn injection(
    py: Python<'_>,
    fault: &str,
    value: Option<Given>,
    phase: Option<Given>,
    high: bool,
) -> PyResult<Injection> {
    let real = |value: Given| match value.real() {
        Some(real) => Ok(real),
        None => error::finite(&format!("fault \"{fault}\": value"), value, ""),
    };
    let value = value.map(real).transpose()?;
    let phases = [("A", Phase::A), ("B", Phase::B), ("C", Phase::C)];
    let phase = phase.map(|name| error::choice("phase", name, &phases)).transpose()?;
    Injection::named(fault, InjectionOptions { value, phase, high }).map_err(|reason| {
        let hint = error::suggestion(py, fault, Injection::NAMES.into_iter());
        let hint = if reason == InjectionError::Unknown { hint } else { String::new() };
        error::parameter(format!("fault \"{fault}\": {reason}{hint}"))
    })
}

/// Builds the configuration of a bench.
#[allow(clippy::too_many_arguments, reason = "those of the Python classes")]
pub(crate) fn config(
    motor: &Motor,
    supply_voltage: Given,
    load: Option<&Load>,
    mode: Given,
    parameters: Option<&Bound<'_, PyAny>>,
    ambient: Given,
    seed: Given,
    pwm_rate: Given,
) -> PyResult<SessionConfig> {
    let mut config = motor.session(motor::supply(supply_voltage)?, motor::mode(mode)?);
    config.load = load.map_or(config.load, Load::config);
    config.parameters = parameters.map_or_else(|| Ok(Vec::new()), numbered)?;
    // As the injection of the same name.
    let ambients = Injection::KINDS.iter().find(|kind| kind.name == "ambient").and_then(|kind| kind.value);
    let (min, max) = ambients.map_or((f64::MIN, f64::MAX), |value| (value.min, value.max));
    config.ambient = error::within("ambient", ambient, "degrees Celsius", min, max)?;
    config.seed = error::whole("seed", seed, "", 0, u64::MAX)?;
    config.board = board(pwm_rate)?;
    Ok(config)
}

/// Returns the board with this PWM rate, Hz.
pub(crate) fn board(pwm_rate: Given) -> PyResult<Board> {
    parse_board(&pwm_rate.to_string())
        .map_err(|refused| error::parameter(format!("pwm_rate {pwm_rate}: {refused}")))
}

/// Returns parameters by number; a key that is a string is a name of the dictionary.
pub(crate) fn numbered(parameters: &Bound<'_, PyAny>) -> PyResult<Vec<(u16, f64)>> {
    error::mapping("parameters", parameters)?
        .items()?
        .iter()
        .map(|item| {
            let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            let number = number(&key)?;
            let unknown = || error::parameter(format!("there is no parameter {number}"));
            let row = Dictionary::row(number).ok_or_else(unknown)?;
            Ok((number, description::entered(row.into(), &value)?))
        })
        .collect()
}

/// Returns the number of a parameter that is given by number or name; case does not matter.
#[pyfunction]
#[pyo3(name = "parameter_number")]
pub(crate) fn number(key: &Bound<'_, PyAny>) -> PyResult<u16> {
    let Ok(name) = key.extract::<String>() else {
        let given: Given = key.extract()?;
        let number = given.whole().and_then(|number| u16::try_from(number).ok());
        let known = number.filter(|number| Dictionary::row(*number).is_some());
        return known.ok_or_else(|| error::parameter(format!("there is no parameter {key}")));
    };
    Dictionary::find(&name).map(|row| row.number).ok_or_else(|| {
        let hint = error::suggestion(key.py(), &name, Dictionary::rows().map(|row| row.name()));
        error::parameter(format!("there is no parameter \"{name}\"{hint}"))
    })
}
