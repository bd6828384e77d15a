//! Changes from outside, and drift with temperature.

use super::injection::{Injected, Injection};
use super::stage::Stage;
use super::{LoadConfig, MotorConfig, Plant, SupplyConfig};

/// Temperature of the motor's data, degrees Celsius.
const REFERENCE_TEMPERATURE: f64 = 25.0;

impl Plant {
    /// Changes the supply: voltage, source resistance, whether it takes current back.
    pub fn set_supply(&mut self, supply: SupplyConfig) {
        self.config.supply = supply;
        self.apply_supply();
    }

    /// Changes the load.
    pub fn set_load(&mut self, load: LoadConfig) {
        self.config.load = load;
        self.stage.set_load(load);
    }

    /// The load now.
    pub fn load(&self) -> LoadConfig {
        self.stage.shaft.load()
    }

    /// Changes the ambient temperature, degrees Celsius. The winding follows with its time constant.
    pub fn set_ambient(&mut self, celsius: f64) {
        self.config.ambient = celsius;
    }

    /// Changes the output of the pressure bridge after its amplifier, V.
    pub fn set_pressure(&mut self, volts: f64) {
        self.config.pressure = volts;
    }

    /// Brings winding and magnets to this temperature at once, degrees Celsius.
    pub fn set_winding_temperature(&mut self, celsius: f64) {
        self.winding_temperature = celsius;
        self.apply_drift();
    }

    /// Breaks something.
    pub fn inject(&mut self, injection: Injection) {
        self.set_injection(injection, true);
    }

    /// Mends what `injection` names; its value does not matter.
    pub fn clear(&mut self, injection: Injection) {
        self.set_injection(injection, false);
    }

    /// Mends everything.
    pub fn clear_all(&mut self) {
        self.injected = Injected::default();
        self.apply_hall_supply();
    }

    fn set_injection(&mut self, injection: Injection, active: bool) {
        self.injected.set(injection, active);
        self.apply_injections();
    }

    pub(super) fn apply_hall_supply(&mut self) {
        self.injected.hall_supply_off = !self.inputs.halls_are_supplied();
        self.apply_injections();
    }

    /// Brings circuit, shaft and sensors into the state that `injected` asks for. The supply comes last,
    /// because with it the network's constants are computed anew ([`Network::update`]).
    ///
    /// [`Network::update`]: super::network::Network::update
    pub(super) fn apply_injections(&mut self) {
        self.stage.arrive();
        self.stage.enter_book();
        self.gates_until = 0.0;
        self.stage.set_open(self.injected.open);
        self.stage.shaft.blocked = self.injected.blocked;
        let leak = self.injected.leak.map_or(0.0, |ohm| 1.0 / ohm.max(1e-3));
        self.stage.network.shunt_g = leak;
        self.stage.network.leak_g = leak + self.config.inverter.own_conductance;
        self.halls.rewire(self.t / self.period * 65_536.0, &self.injected, &mut self.capture);
        self.apply_supply();
    }

    fn apply_supply(&mut self) {
        self.stage.enter_book();
        let mut supply = self.config.supply;
        if let Some(voltage) = self.injected.supply {
            supply.voltage = voltage;
        }
        self.stage.set_supply(&supply);
    }

    /// The winding's temperature after `seconds` with the copper loss since the last call.
    pub(super) fn warm(&mut self, seconds: f64) {
        self.stage.enter_book();
        let motor = &self.config.motor;
        let loss = self.stage.ledger.copper - self.copper_loss_seen;
        self.copper_loss_seen = self.stage.ledger.copper;
        let ambient = self.ambient();
        if motor.thermal_resistance <= 0.0 {
            if self.winding_temperature == ambient {
                return;
            }
            self.winding_temperature = ambient;
        } else {
            let target = ambient + motor.thermal_resistance * loss / seconds;
            let part = (seconds / motor.thermal_time.max(seconds)).min(1.0);
            self.winding_temperature += part * (target - self.winding_temperature);
        }
        self.apply_drift();
    }

    pub(super) fn apply_drift(&mut self) {
        self.stage.set_temperature(&self.config.motor, self.winding_temperature);
    }
}

impl Stage {
    /// Brings winding and magnets to this temperature, degrees Celsius.
    pub(super) fn set_temperature(&mut self, motor: &MotorConfig, celsius: f64) {
        self.arrive();
        self.enter_book();
        let rise = celsius - REFERENCE_TEMPERATURE;
        self.network.copper = 0.5 * motor.resistance * (1.0 + motor.copper_drift * rise).max(0.1);
        self.network.update();
        self.shape.set_drift((1.0 + motor.magnet_drift * rise).max(0.1));
    }
}
