//! Motors and loads.

use crate::bench;
use crate::error::{self, Given};
use crate::notes;
use narx_core::commissioning::{self, Commissioning, Mode, SUPPLY, WRITTEN};
use narx_core::dictionary::engineering;
use narx_core::dictionary::{Access, Dictionary, Parameters};
use narx_sim::plant::{BackEmf, LoadConfig, MotorConfig};
use narx_sim::presets::{self, PRESETS, Preset};
use narx_sim::session::SessionConfig;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::hash::{Hash, Hasher};

/// A star-connected three-phase motor with equal phases, from its data sheet.
///
/// pole_pairs: 1 to 255. resistance: line to line, ohm. inductance: line to line, H. torque_constant: mean
/// torque per DC ampere in ideal six-step, N m/A = 60 / (2 pi speed constant in rpm/V). inertia: rotor,
/// kg m2. static_friction: Coulomb, N m. viscous_friction: N m s/rad. back_emf: "trapezoidal" (flat top of
/// 120 degrees) or "sinusoidal". hall_offset_deg: delay of the hall sensors' edges, electrical degrees.
/// rated_current: DC, A; without it commissioning takes the current that heats the winding by 6 W, at most
/// 6 A. max_speed: largest set-point, mechanical rpm; without it the largest speed at which a given rated
/// current still flows, or without a rated current the no-load speed. thermal_resistance: winding to ambient,
/// K/W; 0 keeps the winding at ambient temperature. thermal_time: time constant of its temperature, s.
/// max_winding_temperature: degrees Celsius; a bench whose winding gets hotter has a note. Raises
/// ParameterError, which names the argument that is out of range.
#[pyclass(module = "narx", frozen, eq, hash)]
#[derive(PartialEq)]
pub(crate) struct Motor {
    config: MotorConfig,
    hall_offset_deg: f64,
    rated_current: Option<f64>,
    max_speed: Option<f64>,
    /// Degrees Celsius.
    max_winding_temperature: f64,
    /// Preset with the properties that no data sheet lists, such as cogging.
    preset: Option<&'static str>,
}

#[pymethods]
impl Motor {
    #[new]
    #[pyo3(signature = (pole_pairs, resistance, inductance, torque_constant, inertia, static_friction=Given::Real(0.0),
                        viscous_friction=Given::Real(0.0), back_emf=Given::word("trapezoidal"),
                        hall_offset_deg=Given::Real(0.0), rated_current=None, max_speed=None, thermal_resistance=Given::Real(0.0),
                        thermal_time=Given::Real(60.0), max_winding_temperature=Given::Real(WINDING_MAX)),
           text_signature = "(pole_pairs, resistance, inductance, torque_constant, inertia, static_friction=0.0, \
                             viscous_friction=0.0, back_emf='trapezoidal', hall_offset_deg=0.0, rated_current=None, \
                             max_speed=None, thermal_resistance=0.0, thermal_time=60.0, max_winding_temperature=155.0)")]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn new(
        pole_pairs: Given,
        resistance: Given,
        inductance: Given,
        torque_constant: Given,
        inertia: Given,
        static_friction: Given,
        viscous_friction: Given,
        back_emf: Given,
        hall_offset_deg: Given,
        rated_current: Option<Given>,
        max_speed: Option<Given>,
        thermal_resistance: Given,
        thermal_time: Given,
        max_winding_temperature: Given,
    ) -> PyResult<Self> {
        let positive = |name, value: Given, unit| {
            error::number(name, value, unit, "a finite number above 0", |value| value > 0.0)
        };
        let config = MotorConfig {
            pole_pairs: error::whole("pole_pairs", pole_pairs, "", 1, u8::MAX)?,
            resistance: positive("resistance", resistance, "ohm")?,
            inductance: positive("inductance", inductance, "H")?,
            torque_constant: positive("torque_constant", torque_constant, "N m/A")?,
            inertia: positive("inertia", inertia, "kg m2")?,
            static_friction: error::within("static_friction", static_friction, "N m", 0.0, LOAD_MAX)?,
            viscous_friction: error::within(
                "viscous_friction",
                viscous_friction,
                "N m s/rad",
                0.0,
                LOAD_MAX,
            )?,
            back_emf: error::choice("back_emf", back_emf, &shapes())?,
            thermal_resistance: error::within(
                "thermal_resistance",
                thermal_resistance,
                "K/W",
                0.0,
                LOAD_MAX,
            )?,
            thermal_time: positive("thermal_time", thermal_time, "s")?,
            ..MotorConfig::default()
        };
        let hall_offset_deg = error::finite("hall_offset_deg", hall_offset_deg, "degrees")?;
        let rated_current = rated_current.map(|value| positive("rated_current", value, "A")).transpose()?;
        let max_speed = max_speed.map(|value| positive("max_speed", value, "rpm")).transpose()?;
        let max_winding_temperature = error::within(
            "max_winding_temperature",
            max_winding_temperature,
            "degrees Celsius",
            40.0,
            1000.0,
        )?;
        Ok(Self { config, hall_offset_deg, rated_current, max_speed, max_winding_temperature, preset: None })
    }

    /// Names of the real motors that `preset` knows.
    #[staticmethod]
    fn presets() -> Vec<&'static str> {
        PRESETS.iter().map(|preset| preset.name).collect()
    }

    /// Returns a real motor by its name; `sim/src/presets/` has the source of every figure.
    ///
    /// There are ec45-flat-50w-18v, ec45-flat-50w-36v, ec45-flat-70w-36v, ec45-flat-70w-60v,
    /// ec90-flat-90w-24v, ec-max40-120w-48v, ec4pole30-200w-36v, ec-i40-100w-48v, 4221g018bxth-18v,
    /// 4221g024bxth-24v, bly172s-24v, bly171d-24v, qbl5704-36v, dma0204024b101-24v, bldc-1-25-058-201-24v,
    /// db42m03-24v, bm-180e-24v, am8112-0f21-48v.
    #[staticmethod]
    fn preset(py: Python<'_>, name: Given) -> PyResult<Self> {
        let Given::Word(name) = &name else {
            return Err(error::parameter(format!(
                "there is no preset {name}; there are {}",
                Self::presets().join(", ")
            )));
        };
        let preset = presets::preset(name).ok_or_else(|| {
            let hint = error::suggestion(py, name, PRESETS.iter().map(|preset| preset.name));
            let names = Self::presets().join(", ");
            error::parameter(format!("there is no preset \"{name}\"{hint}; there are {names}"))
        })?;
        let (config, rated_current) = (preset.motor, preset.data.rated_current);
        Ok(Self {
            config,
            hall_offset_deg: 0.0,
            rated_current,
            max_speed: None,
            max_winding_temperature: WINDING_MAX,
            preset: Some(preset.name),
        })
    }

    /// Returns this motor with some arguments of the constructor changed. Properties of a preset beyond
    /// those, such as cogging, are kept.
    #[pyo3(signature = (**changes))]
    fn replace(&self, py: Python<'_>, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let arguments = self.arguments(py)?;
        for (name, value) in changes.into_iter().flatten() {
            let name: String = name.extract()?;
            if !arguments.contains(&name)? {
                let names: Vec<String> = arguments.keys().extract()?;
                let hint = error::suggestion(py, &name, names.iter().map(String::as_str));
                return Err(error::parameter(format!("a motor has no \"{name}\"{hint}")));
            }
            arguments.set_item(name, value)?;
        }
        let given = py.get_type::<Self>().call((), Some(&arguments))?.cast_into::<Self>()?;
        let Self { config, hall_offset_deg, rated_current, max_speed, max_winding_temperature, .. } =
            *given.get();
        let MotorConfig { pole_pairs, resistance, inductance, torque_constant, inertia, .. } = config;
        let MotorConfig { static_friction, viscous_friction, back_emf, .. } = config;
        let MotorConfig { thermal_resistance, thermal_time, .. } = config;
        let figures =
            MotorConfig { pole_pairs, resistance, inductance, torque_constant, inertia, ..self.config };
        // The name of the shape does not determine the width of a trapezoid's top.
        let same_shape = given.get().back_emf() == self.back_emf();
        let back_emf = if same_shape { self.config.back_emf } else { back_emf };
        let figures = MotorConfig { thermal_resistance, thermal_time, ..figures };
        let config = MotorConfig { static_friction, viscous_friction, back_emf, ..figures };
        Ok(Self {
            config,
            hall_offset_deg,
            rated_current,
            max_speed,
            max_winding_temperature,
            preset: self.preset,
        })
    }

    /// Pickles the arguments that rebuild the motor.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        Ok((py.import("narx._core")?.getattr("restore_motor")?, (self.preset, self.arguments(py)?)))
    }

    /// Returns the parameters of a drive for this motor on `supply_voltage` volts by the design rules: name
    /// -> value in its unit. Those in `narx.COMMISSIONED` are the motor's, every other one has its factory
    /// value. pwm_rate: of its board, 8 000 to 50 000 Hz.
    #[pyo3(signature = (supply_voltage, mode=Given::word("sensorless"), pwm_rate=Given::Whole(10_000)),
           text_signature = "($self, supply_voltage, mode='sensorless', pwm_rate=10000)")]
    fn commission<'py>(
        &self,
        py: Python<'py>,
        supply_voltage: Given,
        mode: Given,
        pwm_rate: Given,
    ) -> PyResult<Bound<'py, PyDict>> {
        let commissioning = self.commissioning(supply_voltage, mode, pwm_rate)?;
        dictionary(py, &commissioning.parameters)
    }

    /// Returns the speeds that a drive for this motor accepts on `supply_voltage` volts, and the allowed load
    /// at each.
    #[pyo3(signature = (supply_voltage, mode=Given::word("sensorless"), pwm_rate=Given::Whole(10_000)),
           text_signature = "($self, supply_voltage, mode='sensorless', pwm_rate=10000)")]
    fn operating_range(
        &self,
        supply_voltage: Given,
        mode: Given,
        pwm_rate: Given,
    ) -> PyResult<OperatingRange> {
        self.commissioning(supply_voltage, mode, pwm_rate).map(OperatingRange)
    }

    /// Returns the speed loop with this bandwidth, Hz; without it the fastest one with 60 degrees of phase
    /// margin. speed_min: slowest set-point, mechanical rpm: the measured speed is the mean of an electrical
    /// revolution, so slower set-points allow less. The inertia of a coupled load belongs to the motor here:
    /// `motor.replace(inertia=...)`. Raises ParameterError, which names the largest bandwidth.
    #[pyo3(signature = (speed_min, bandwidth=None), text_signature = "($self, speed_min, bandwidth=None)")]
    fn speed_loop(&self, speed_min: Given, bandwidth: Option<Given>) -> PyResult<SpeedLoop> {
        let speed_min = error::finite("speed_min", speed_min, "rpm")?;
        let bandwidth = bandwidth.map(|given| error::finite("bandwidth", given, "Hz")).transpose()?;
        self.config.figures().speed_loop(speed_min, bandwidth).map(SpeedLoop).map_err(error::parameter)
    }

    /// Name of a preset; `None` of any other motor.
    #[getter]
    fn name(&self) -> Option<&'static str> {
        let same = |preset: &&Preset| {
            preset.motor == self.config
                && preset.data.rated_current == self.rated_current
                && self.hall_offset_deg == 0.0
                && self.max_speed.is_none()
                && self.max_winding_temperature == WINDING_MAX
        };
        self.base().filter(same).map(|preset| preset.name)
    }

    /// Rated DC current, A; `None` if unknown.
    #[getter]
    fn rated_current(&self) -> Option<f64> {
        self.rated_current
    }

    /// Largest set-point, mechanical rpm; `None` if it was not given.
    #[getter]
    fn max_speed(&self) -> Option<f64> {
        self.max_speed
    }

    /// Thermal resistance from the winding to ambient, K/W; 0 of a winding that stays at ambient temperature.
    #[getter]
    fn thermal_resistance(&self) -> f64 {
        self.config.thermal_resistance
    }

    /// Time constant of the winding's temperature, s.
    #[getter]
    fn thermal_time(&self) -> f64 {
        self.config.thermal_time
    }

    /// Largest temperature of the winding, degrees Celsius.
    #[getter]
    pub(crate) fn max_winding_temperature(&self) -> f64 {
        self.max_winding_temperature
    }

    /// Nominal voltage, V, of a preset.
    #[getter]
    fn nominal_voltage(&self) -> Option<f64> {
        Some(self.base()?.data.nominal_voltage)
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

    /// Delay of the hall sensors' edges, electrical degrees.
    #[getter]
    fn hall_offset_deg(&self) -> f64 {
        self.hall_offset_deg
    }

    fn __repr__(&self) -> String {
        let MotorConfig { pole_pairs, resistance, inductance, torque_constant, inertia, .. } = self.config;
        let name = self.name().map_or_else(String::new, |name| format!(" {name}:"));
        format!(
            "<narx.Motor{name} {pole_pairs} pole pairs, {resistance} ohm, {inductance} H, {torque_constant} N m/A, {inertia} kg m2>"
        )
    }
}

impl Motor {
    /// Returns the configuration of a session with this motor, everything else at its default.
    pub(crate) fn session(&self, supply: f64, mode: Mode) -> SessionConfig {
        SessionConfig {
            rated_current: self.rated_current,
            speed_max: self.max_speed,
            hall_offset_deg: self.hall_offset_deg,
            label: format!("{}, {}", self.name().unwrap_or("motor"), mode.name()),
            ..SessionConfig::new(self.config, supply, mode)
        }
    }

    /// Figures of the motor.
    pub(crate) const fn config(&self) -> MotorConfig {
        self.config
    }

    /// Delay of the hall sensors' edges, electrical degrees.
    pub(crate) const fn hall_offset(&self) -> f64 {
        self.hall_offset_deg
    }

    /// Returns what commissioning makes of it, on a board with this PWM rate.
    fn commissioning(&self, supply: Given, mode: Given, pwm_rate: Given) -> PyResult<Commissioning> {
        let board = bench::board(pwm_rate)?;
        let config = SessionConfig { board, ..self.session(self::supply(supply)?, self::mode(mode)?) };
        config.commission().map_err(error::parameter)
    }

    fn base(&self) -> Option<&'static Preset> {
        presets::preset(self.preset?)
    }

    /// Returns the arguments of the constructor that build this motor.
    fn arguments<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let arguments = PyDict::new(py);
        arguments.set_item("pole_pairs", self.pole_pairs())?;
        arguments.set_item("resistance", self.resistance())?;
        arguments.set_item("inductance", self.inductance())?;
        arguments.set_item("torque_constant", self.torque_constant())?;
        arguments.set_item("inertia", self.inertia())?;
        arguments.set_item("static_friction", self.static_friction())?;
        arguments.set_item("viscous_friction", self.viscous_friction())?;
        arguments.set_item("back_emf", self.back_emf())?;
        arguments.set_item("hall_offset_deg", self.hall_offset_deg())?;
        arguments.set_item("rated_current", self.rated_current)?;
        arguments.set_item("max_speed", self.max_speed)?;
        arguments.set_item("thermal_resistance", self.thermal_resistance())?;
        arguments.set_item("thermal_time", self.thermal_time())?;
        arguments.set_item("max_winding_temperature", self.max_winding_temperature)?;
        Ok(arguments)
    }
}

/// Gains of the speed loop, and what they bring.
#[pyclass(module = "narx", frozen)]
pub(crate) struct SpeedLoop(commissioning::SpeedLoop);

#[pymethods]
impl SpeedLoop {
    /// Frequency at which the open loop has a gain of 1, Hz.
    #[getter]
    fn bandwidth(&self) -> f64 {
        self.0.bandwidth
    }

    /// Phase margin at the slowest set-point, degrees; it is larger at every other.
    #[getter]
    fn phase_margin(&self) -> f64 {
        self.0.phase_margin
    }

    /// Slowest set-point, mechanical rpm.
    #[getter]
    fn speed_min(&self) -> f64 {
        self.0.speed_min
    }

    /// Gains and slowest set-point of both modes, for `drive.parameters.load` and
    /// `narx.Bench(parameters=...)`: name -> value in its unit. Raises ParameterError for a value outside its
    /// parameter's range.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut parameters = Parameters::new();
        self.0.write(&mut parameters).map_err(error::parameter)?;
        let all = dictionary(py, &parameters)?;
        let values = PyDict::new(py);
        for number in commissioning::SpeedLoop::WRITTEN {
            let Some(row) = Dictionary::row(number) else { continue };
            values.set_item(row.name(), all.get_item(row.name())?)?;
        }
        Ok(values)
    }

    fn __repr__(&self) -> String {
        let SpeedLoop(found) = self;
        format!(
            "SpeedLoop({:.2} Hz, phase margin {:.0} degrees from {} rpm on)",
            found.bandwidth, found.phase_margin, found.speed_min
        )
    }
}

/// The speeds (rpm) that a commissioned drive accepts, and the load (N m) that is allowed at each, besides
/// the motor's own friction.
#[pyclass(module = "narx", frozen)]
pub(crate) struct OperatingRange(Commissioning);

#[pymethods]
impl OperatingRange {
    /// Smallest set-point, mechanical rpm.
    #[getter]
    fn speed_min(&self) -> f64 {
        self.0.speed_min
    }

    /// Largest set-point, mechanical rpm.
    #[getter]
    fn speed_max(&self) -> f64 {
        self.0.speed_max
    }

    /// Limit that determines the largest set-point: "voltage", "peak current" (ripple below 12 A), "control
    /// ticks" (two a sector), "samples" (four of back-EMF a sector), "reported speed" (32,767 rpm), or
    /// "asked" (the motor's max_speed).
    #[getter]
    fn speed_limit(&self) -> &'static str {
        self.0.speed_limit.name()
    }

    /// The motor's rated DC current, given or estimated, A.
    #[getter]
    fn rated_current(&self) -> f64 {
        self.0.rated_current
    }

    /// Speeds from speed_min to speed_max in equal steps, mechanical rpm.
    #[getter]
    fn speed(&self) -> Vec<f64> {
        self.0.torque.iter().map(|point| point.speed).collect()
    }

    /// Continuous torque at the shaft at each speed, N m.
    #[getter]
    fn torque(&self) -> Vec<f64> {
        self.0.torque.iter().map(|point| point.torque).collect()
    }

    /// Limit of the torque at each speed: "rated current", "phase current", "power", "bus current" or
    /// "voltage".
    #[getter]
    fn torque_limit(&self) -> Vec<&'static str> {
        self.0.torque.iter().map(|point| point.limit.name()).collect()
    }

    /// Limits of the drive that restrict this motor, a sentence each.
    #[getter]
    fn notes(&self) -> Vec<String> {
        notes::notes(&self.0)
    }

    fn __repr__(&self) -> String {
        let Commissioning { speed_min, speed_max, .. } = self.0;
        format!(
            "<narx.OperatingRange {speed_min:.0} to {speed_max:.0} rpm, limited by {}>",
            self.0.speed_limit.name()
        )
    }
}

/// Pickled form of a motor: the function that rebuilds it, and its arguments.
type Reduced<'py> = (Bound<'py, PyAny>, (Option<&'static str>, Bound<'py, PyDict>));

impl Hash for Motor {
    fn hash<H: Hasher>(&self, state: &mut H) {
        // Equal motors have equal values of these; different motors rarely do.
        let MotorConfig { pole_pairs, resistance, inductance, inertia, .. } = self.config;
        (pole_pairs, resistance.to_bits(), inductance.to_bits(), inertia.to_bits()).hash(state);
    }
}

/// Rebuilds a pickled motor.
#[pyfunction]
pub(crate) fn restore_motor(
    py: Python<'_>,
    preset: Option<&str>,
    arguments: &Bound<'_, PyDict>,
) -> PyResult<Motor> {
    match preset {
        Some(name) => Motor::preset(py, Given::word(name))?.replace(py, Some(arguments)),
        None => {
            let motor = py.get_type::<Motor>().call((), Some(arguments))?.cast_into::<Motor>()?;
            Ok(Motor { ..*motor.get() })
        }
    }
}

/// Largest temperature of a winding that names none, that of insulation class F (IEC 60085), degrees Celsius.
const WINDING_MAX: f64 = 155.0;
/// Largest voltage of a supply, as of the injection "supply", V.
pub(crate) const VOLTAGE_MAX: f64 = 80.0;
/// Largest figure of a load or a friction, in SI units: it holds every motor of this drive.
const LOAD_MAX: f64 = LoadConfig::MAX;

/// A load on the shaft. constant, viscous and quadratic oppose the motion.
///
/// constant: N m, like Coulomb friction; it also acts at standstill. viscous: N m s/rad. quadratic: N m
/// s2/rad2. inertia: kg m2, rigidly coupled. Each of them is 0 to 1000. machine: torque of a dynamometer,
/// -1000 to 1000 N m, which acts against Forward whichever way the shaft turns, also at standstill; a
/// negative one drives Forward. Raises ParameterError for another value.
#[pyclass(module = "narx", frozen, get_all, eq, hash)]
#[derive(PartialEq)]
pub(crate) struct Load {
    /// Constant torque, like Coulomb friction, N m.
    constant: f64,
    /// Torque proportional to the speed, N m s/rad.
    viscous: f64,
    /// Torque proportional to the square of the speed, N m s2/rad2.
    quadratic: f64,
    /// Inertia, rigidly coupled, kg m2.
    inertia: f64,
    /// Torque of a dynamometer against Forward, N m.
    machine: f64,
}

#[pymethods]
impl Load {
    #[new]
    #[pyo3(signature = (constant=Given::Real(0.0), viscous=Given::Real(0.0), quadratic=Given::Real(0.0), inertia=Given::Real(0.0),
                        machine=Given::Real(0.0)),
           text_signature = "(constant=0.0, viscous=0.0, quadratic=0.0, inertia=0.0, machine=0.0)")]
    fn new(
        constant: Given,
        viscous: Given,
        quadratic: Given,
        inertia: Given,
        machine: Given,
    ) -> PyResult<Self> {
        Ok(Self {
            constant: error::within("constant", constant, "N m", 0.0, LOAD_MAX)?,
            viscous: error::within("viscous", viscous, "N m s/rad", 0.0, LOAD_MAX)?,
            quadratic: error::within("quadratic", quadratic, "N m s2/rad2", 0.0, LOAD_MAX)?,
            inertia: error::within("inertia", inertia, "kg m2", 0.0, LOAD_MAX)?,
            machine: error::within("machine", machine, "N m", -LOAD_MAX, LOAD_MAX)?,
        })
    }

    /// Pickles the arguments that rebuild the load.
    const fn __getnewargs__(&self) -> (f64, f64, f64, f64, f64) {
        let Self { constant, viscous, quadratic, inertia, machine } = *self;
        (constant, viscous, quadratic, inertia, machine)
    }

    fn __repr__(&self) -> String {
        let Self { constant, viscous, quadratic, inertia, machine } = self;
        let machine = if *machine == 0.0 { String::new() } else { format!(", machine {machine} N m") };
        format!(
            "<narx.Load {constant} N m, {viscous} N m s/rad, {quadratic} N m s2/rad2, {inertia} kg m2{machine}>"
        )
    }
}

impl Load {
    /// Returns the load's configuration for a bench.
    pub(crate) const fn config(&self) -> LoadConfig {
        let Self { constant, viscous, quadratic, inertia, machine } = *self;
        LoadConfig { constant, viscous, quadratic, inertia, machine }
    }
}

impl Hash for Load {
    fn hash<H: Hasher>(&self, state: &mut H) {
        let Self { constant, viscous, quadratic, inertia, machine } = self;
        // 0 and -0 are equal, so they must have the same hash.
        [constant, viscous, quadratic, inertia, machine].map(|value| (value + 0.0).to_bits()).hash(state);
    }
}

/// Returns a supply voltage; commissioning checks its range.
pub(crate) fn supply(voltage: Given) -> PyResult<f64> {
    error::number(
        "supply_voltage",
        voltage,
        "V",
        &format!("a number from {} to {}", SUPPLY.start(), SUPPLY.end()),
        |_| true,
    )
}

/// Returns the control mode with this name.
pub(crate) fn mode(name: Given) -> PyResult<Mode> {
    error::choice("mode", name, &Mode::ALL.map(|mode| (mode.name(), mode)))
}

/// Returns the parameters that can be set, by name: whole numbers if the scale has no fraction.
fn dictionary<'py>(py: Python<'py>, parameters: &Parameters) -> PyResult<Bound<'py, PyDict>> {
    let values = PyDict::new(py);
    for (row, raw) in parameters.iter().filter(|(row, _)| row.access != Access::ReadOnly && !row.command) {
        let value = engineering::to_unit(row, row.kind.widen(raw));
        if row.exponent < 0 {
            values.set_item(row.name(), value)?;
        } else {
            values.set_item(row.name(), value as i64)?;
        }
    }
    Ok(values)
}

/// Names of the parameters that commissioning writes.
pub(crate) fn commissioned(py: Python<'_>) -> PyResult<Bound<'_, PyTuple>> {
    PyTuple::new(py, WRITTEN.map(|number| Dictionary::row(number).map(|row| row.name())))
}

fn shapes() -> [(&'static str, BackEmf); 2] {
    [("trapezoidal", MotorConfig::default().back_emf), ("sinusoidal", BackEmf::Sinusoidal)]
}
