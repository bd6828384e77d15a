//! The plant whose gates the caller sets.

use crate::error::{self, Given};
use crate::motor::{self, Load, Motor};
use narx_sim::plant::{Gate, GatedPlant, HallConfig, InverterConfig, PlantConfig, SupplyConfig};
use pyo3::prelude::*;
use std::f64::consts::TAU;

/// Largest time of a call of `advance`, s.
const ADVANCE_MAX: f64 = 1.0;
/// Largest speed at the start, rpm.
const SPEED_MAX: f64 = 1e6;

/// A motor with bridge, supply, load and hall sensors, whose gates the caller sets: for a drive of your own,
/// a model of its timer or its whole chip.
///
/// Switches act at once; dead times are the caller's. Every stretch between two changes is solved exactly.
/// motor: a narx.Motor, whose winding stays at the ambient temperature. supply_voltage: V. load: a narx.Load.
/// angle_deg: electrical angle at the start, degrees; 0 is the rising zero crossing of phase A's back-EMF.
/// speed: mechanical, at the start, rpm. on_resistance: of a switch, ohm. diode_drop: of its diode, V.
/// capacitance: of the bus, F. hall_order: row of the six orders of hall lines, 0 is A, B, C. Raises
/// ParameterError, which names the argument that is out of range.
///
/// >>> plant = narx.Plant(narx.Motor.preset("bly172s-24v"), supply_voltage=24.0)
/// >>> plant.set_gates("high", "low", "off")
/// >>> plant.advance(20e-6)
/// 2e-05
/// >>> plant.currents[0] > 0.0
/// True
#[pyclass(module = "narx")]
pub(crate) struct Plant {
    plant: GatedPlant,
    supply: SupplyConfig,
    pole_pairs: f64,
}

#[pymethods]
impl Plant {
    #[new]
    #[pyo3(signature = (motor, supply_voltage=Given::Real(24.0), load=None, angle_deg=Given::Real(77.0), speed=Given::Real(0.0),
                        on_resistance=Given::Real(0.02), diode_drop=Given::Real(0.8), capacitance=Given::Real(100e-6),
                        hall_order=Given::Whole(0)),
           text_signature = "(motor, supply_voltage=24.0, load=None, angle_deg=77.0, speed=0.0, on_resistance=0.02, \
                             diode_drop=0.8, capacitance=0.0001, hall_order=0)")]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn new(
        motor: &Motor,
        supply_voltage: Given,
        load: Option<&Load>,
        angle_deg: Given,
        speed: Given,
        on_resistance: Given,
        diode_drop: Given,
        capacitance: Given,
        hall_order: Given,
    ) -> PyResult<Self> {
        let positive = |name, value: Given, unit| {
            error::number(name, value, unit, "a finite number above 0", |value| value > 0.0)
        };
        let mut config = PlantConfig::new(motor.config(), voltage(supply_voltage)?);
        config.load = load.map_or(config.load, Load::config);
        config.angle_deg = error::finite("angle_deg", angle_deg, "degrees")?;
        config.speed = error::within("speed", speed, "rpm", -SPEED_MAX, SPEED_MAX)? * TAU / 60.0;
        config.inverter = InverterConfig {
            on_resistance: positive("on_resistance", on_resistance, "ohm")?,
            diode_drop: positive("diode_drop", diode_drop, "V")?,
            capacitance: positive("capacitance", capacitance, "F")?,
            ..config.inverter
        };
        config.hall = HallConfig {
            offset_deg: motor.hall_offset(),
            order: error::whole("hall_order", hall_order, "", 0, 5)?,
            ..config.hall
        };
        let pole_pairs = f64::from(config.motor.pole_pairs);
        Ok(Self { plant: GatedPlant::new(&config), supply: config.supply, pole_pairs })
    }

    /// Sets the gates of legs A, B and C from now on: "high", "low" or "off" each.
    fn set_gates(&mut self, a: Given, b: Given, c: Given) -> PyResult<()> {
        self.plant.set_gates([gate("a", a)?, gate("b", b)?, gate("c", c)?]);
        Ok(())
    }

    /// Advances by at most `seconds`, 0 to 1; returns by how much. Ends early right after the hall lines have
    /// changed (`hall_edges`), and where the current of a shunt passes `shunt_limit`, A, upwards.
    #[pyo3(signature = (seconds, shunt_limit=None))]
    fn advance(&mut self, py: Python<'_>, seconds: Given, shunt_limit: Option<Given>) -> PyResult<f64> {
        let seconds = error::within("seconds", seconds, "s", 0.0, ADVANCE_MAX)?;
        let limit = shunt_limit.map(|limit| error::finite("shunt_limit", limit, "A")).transpose()?;
        let plant = &mut self.plant;
        Ok(py.detach(|| plant.advance(seconds, limit)))
    }

    /// Changes of the hall lines during the last `advance`: time, s since the start, and lines after it.
    #[getter]
    fn hall_edges(&self) -> Vec<(f64, u8)> {
        self.plant.hall_edges().map(|edge| (edge.time, edge.code)).collect()
    }

    /// Hall lines: bit 0 = A, bit 1 = B, bit 2 = C.
    #[getter]
    fn hall(&self) -> u8 {
        self.plant.hall()
    }

    /// Time since the start, s.
    #[getter]
    fn time(&self) -> f64 {
        self.plant.time()
    }

    /// Mechanical speed, rpm.
    #[getter]
    fn speed(&self) -> f64 {
        self.plant.speed() * 60.0 / TAU
    }

    /// Mechanical angle, degrees, unwrapped.
    #[getter]
    fn angle_deg(&self) -> f64 {
        self.plant.electrical_turns() * 360.0 / self.pole_pairs
    }

    /// Phase currents into the motor, A.
    #[getter]
    fn currents(&self) -> (f64, f64, f64) {
        self.plant.currents().into()
    }

    /// Currents of the shunts under the low sides, A: positive from the phase to ground.
    #[getter]
    fn shunts(&self) -> (f64, f64, f64) {
        self.plant.shunts().into()
    }

    /// Voltages of the terminals against ground, V.
    #[getter]
    fn terminals(&self) -> (f64, f64, f64) {
        self.plant.terminals().into()
    }

    /// Bus voltage, V.
    #[getter]
    fn bus_voltage(&self) -> f64 {
        self.plant.bus_voltage()
    }

    /// Charge that the bridge has taken from the bus since the start, A s: its change over some time is the
    /// mean bus current.
    #[getter]
    fn charge(&self) -> f64 {
        self.plant.charge()
    }

    /// Replaces the load.
    fn set_load(&mut self, load: &Load) {
        self.plant.set_load(load.config());
    }

    /// Changes the supply's voltage, V.
    fn set_supply(&mut self, supply_voltage: Given) -> PyResult<()> {
        self.supply.voltage = voltage(supply_voltage)?;
        self.plant.set_supply(&self.supply);
        Ok(())
    }

    /// Blocks the rotor, or frees it.
    fn set_blocked(&mut self, blocked: &Bound<'_, PyAny>) -> PyResult<()> {
        self.plant.set_blocked(error::flag("blocked", blocked)?);
        Ok(())
    }

    /// Breaks the cables of these phases, "A", "B", "C" or several of them; mends the others.
    fn set_open(&mut self, phases: &str) -> PyResult<()> {
        if let Some(other) = phases.chars().find(|phase| !"ABC".contains(*phase)) {
            return Err(error::parameter(format!("phases '{other}': must be of A, B and C")));
        }
        self.plant.set_open(["A", "B", "C"].map(|phase| phases.contains(phase)));
        Ok(())
    }

    fn __repr__(&self) -> String {
        format!("<narx.Plant at {:.6} s, {:.0} rpm>", self.time(), self.speed())
    }
}

fn voltage(given: Given) -> PyResult<f64> {
    error::within("supply_voltage", given, "V", 0.0, motor::VOLTAGE_MAX)
}

fn gate(leg: &str, given: Given) -> PyResult<Gate> {
    error::choice(leg, given, &[("off", Gate::Off), ("high", Gate::High), ("low", Gate::Low)])
}
