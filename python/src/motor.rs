//! Motors and loads.

use crate::error;
use narx_core::dictionary::{Access, Parameters};
use narx_sim::commissioning::Mode;
use narx_sim::engineering;
use narx_sim::plant::{BackEmf, LoadConfig, MotorConfig};
use narx_sim::presets::{self, PRESETS};
use narx_sim::session::SessionConfig;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A star-connected three-phase motor with equal phases, from its data sheet.
///
/// pole_pairs: 1 to 255. resistance: line to line, ohm. inductance: line to line, H. torque_constant: mean torque per
/// DC ampere in ideal six-step, N m/A = 60 / (2 pi speed constant in rpm/V). inertia: rotor, kg m2. static_friction:
/// Coulomb, N m. viscous_friction: N m s/rad. back_emf: "trapezoidal" (flat top of 120 degrees) or "sinusoidal".
/// hall_offset_deg: hall sensors come this much late, electrical degrees. Raises ParameterError, which names what cannot be.
#[pyclass(module = "narx", frozen)]
pub(crate) struct Motor {
    config: MotorConfig,
    hall_offset_deg: f64,
    /// Rated DC current of a preset, A; `None` where its data sheet has none.
    #[pyo3(get)]
    rated_current: Option<f64>,
    /// Name of a preset.
    #[pyo3(get)]
    name: Option<&'static str>,
}

#[pymethods]
impl Motor {
    #[new]
    #[pyo3(signature = (pole_pairs, resistance, inductance, torque_constant, inertia, static_friction=0.0,
                        viscous_friction=0.0, back_emf="trapezoidal", hall_offset_deg=0.0))]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn new(
        pole_pairs: f64,
        resistance: f64,
        inductance: f64,
        torque_constant: f64,
        inertia: f64,
        static_friction: f64,
        viscous_friction: f64,
        back_emf: &str,
        hall_offset_deg: f64,
    ) -> PyResult<Self> {
        let positive = |name, value, unit| {
            error::number(name, value, unit, "a finite number above 0", |value| value > 0.0)
        };
        let config = MotorConfig {
            pole_pairs: error::whole("pole_pairs", pole_pairs, "", 1.0, 255.0)? as u8,
            resistance: positive("resistance", resistance, "ohm")?,
            inductance: positive("inductance", inductance, "H")?,
            torque_constant: positive("torque_constant", torque_constant, "N m/A")?,
            inertia: positive("inertia", inertia, "kg m2")?,
            static_friction: error::magnitude("static_friction", static_friction, "N m")?,
            viscous_friction: error::magnitude("viscous_friction", viscous_friction, "N m s/rad")?,
            back_emf: error::choice("back_emf", back_emf, &shapes())?,
            ..MotorConfig::default()
        };
        let hall_offset_deg = error::finite("hall_offset_deg", hall_offset_deg, "degrees")?;
        Ok(Self { config, hall_offset_deg, rated_current: None, name: None })
    }

    /// Names of the real motors that `preset` knows.
    #[staticmethod]
    fn presets() -> Vec<&'static str> {
        PRESETS.iter().map(|preset| preset.name).collect()
    }

    /// A real motor by its name; every figure's source is in `sim/src/presets.rs`.
    #[staticmethod]
    fn preset(py: Python<'_>, name: &str) -> PyResult<Self> {
        let preset = presets::preset(name).ok_or_else(|| {
            let hint = error::suggestion(py, name, PRESETS.iter().map(|preset| preset.name));
            let names = Self::presets().join(", ");
            error::parameter(format!("there is no preset \"{name}\"{hint}; there are {names}"))
        })?;
        let rated_current = preset.data.rated_current;
        Ok(Self { config: preset.motor, hall_offset_deg: 0.0, rated_current, name: Some(preset.name) })
    }

    /// The parameters of a drive for this motor on `supply_voltage` volts by the design rules: name -> value in its unit.
    #[pyo3(signature = (supply_voltage, mode="sensorless"))]
    fn commission<'py>(
        &self,
        py: Python<'py>,
        supply_voltage: f64,
        mode: &str,
    ) -> PyResult<Bound<'py, PyDict>> {
        let commissioning =
            self.session(supply_voltage, self::mode(mode)?).commission().map_err(error::parameter)?;
        dictionary(py, &commissioning.parameters)
    }

    /// Pole pairs.
    #[getter]
    fn pole_pairs(&self) -> u8 {
        self.config.pole_pairs
    }

    /// Line to line, ohm.
    #[getter]
    fn resistance(&self) -> f64 {
        self.config.resistance
    }

    /// Line to line, H.
    #[getter]
    fn inductance(&self) -> f64 {
        self.config.inductance
    }

    /// Mean torque per DC ampere in ideal six-step, N m/A.
    #[getter]
    fn torque_constant(&self) -> f64 {
        self.config.torque_constant
    }

    /// Rotor, kg m2.
    #[getter]
    fn inertia(&self) -> f64 {
        self.config.inertia
    }

    /// Coulomb friction, N m.
    #[getter]
    fn static_friction(&self) -> f64 {
        self.config.static_friction
    }

    /// Viscous friction, N m s/rad.
    #[getter]
    fn viscous_friction(&self) -> f64 {
        self.config.viscous_friction
    }

    /// "trapezoidal" or "sinusoidal".
    #[getter]
    fn back_emf(&self) -> &'static str {
        let [(trapezoidal, _), (sinusoidal, _)] = shapes();
        if self.config.back_emf == BackEmf::Sinusoidal { sinusoidal } else { trapezoidal }
    }

    /// Hall sensors come this much late, electrical degrees.
    #[getter]
    fn hall_offset_deg(&self) -> f64 {
        self.hall_offset_deg
    }

    fn __repr__(&self) -> String {
        let MotorConfig { pole_pairs, resistance, inductance, torque_constant, inertia, .. } = self.config;
        let name = self.name.map_or_else(String::new, |name| format!(" {name}:"));
        format!(
            "<narx.Motor{name} {pole_pairs} pole pairs, {resistance} ohm, {inductance} H, {torque_constant} N m/A, {inertia} kg m2>"
        )
    }
}

impl Motor {
    /// A session with this motor, everything else at its default.
    pub(crate) fn session(&self, supply: f64, mode: Mode) -> SessionConfig {
        SessionConfig {
            rated_current: self.rated_current,
            hall_offset_deg: self.hall_offset_deg,
            label: format!("{}, {}", self.name.unwrap_or("motor"), mode.name()),
            ..SessionConfig::new(self.config, supply, mode)
        }
    }
}

/// A load on the shaft. All torques oppose the motion; the constant one also holds at standstill.
///
/// constant: N m, like Coulomb friction. viscous: N m s/rad. quadratic: N m s2/rad2. inertia: kg m2, rigidly coupled. Raises ParameterError for one that is not
/// finite, or negative.
#[pyclass(module = "narx", frozen, get_all)]
pub(crate) struct Load {
    /// Like Coulomb friction, N m.
    constant: f64,
    /// Grows with the speed, N m s/rad.
    viscous: f64,
    /// Grows with its square, N m s2/rad2.
    quadratic: f64,
    /// Rigidly coupled, kg m2.
    inertia: f64,
}

#[pymethods]
impl Load {
    #[new]
    #[pyo3(signature = (constant=0.0, viscous=0.0, quadratic=0.0, inertia=0.0))]
    fn new(constant: f64, viscous: f64, quadratic: f64, inertia: f64) -> PyResult<Self> {
        Ok(Self {
            constant: error::magnitude("constant", constant, "N m")?,
            viscous: error::magnitude("viscous", viscous, "N m s/rad")?,
            quadratic: error::magnitude("quadratic", quadratic, "N m s2/rad2")?,
            inertia: error::magnitude("inertia", inertia, "kg m2")?,
        })
    }

    fn __repr__(&self) -> String {
        let Self { constant, viscous, quadratic, inertia } = self;
        format!("<narx.Load {constant} N m, {viscous} N m s/rad, {quadratic} N m s2/rad2, {inertia} kg m2>")
    }
}

impl Load {
    /// What the bench is built with.
    pub(crate) const fn config(&self) -> LoadConfig {
        let Self { constant, viscous, quadratic, inertia } = *self;
        LoadConfig { constant, viscous, quadratic, inertia }
    }
}

/// The control mode of that name.
pub(crate) fn mode(name: &str) -> PyResult<Mode> {
    error::choice("mode", name, &Mode::ALL.map(|mode| (mode.name(), mode)))
}

/// What can be set, by name: whole numbers where the scale has no fraction.
fn dictionary<'py>(py: Python<'py>, parameters: &Parameters) -> PyResult<Bound<'py, PyDict>> {
    let values = PyDict::new(py);
    for (row, raw) in parameters.iter().filter(|(row, _)| row.access != Access::ReadOnly && !row.command) {
        let value = engineering::to_unit(row, row.kind.widen(raw));
        if row.exponent < 0 {
            values.set_item(row.name, value)?;
        } else {
            values.set_item(row.name, value as i64)?;
        }
    }
    Ok(values)
}

fn shapes() -> [(&'static str, BackEmf); 2] {
    [("trapezoidal", MotorConfig::default().back_emf), ("sinusoidal", BackEmf::Sinusoidal)]
}
