//! What the board reads besides the tick's samples.

use super::Plant;
use narx_core::motor::Lines;
use narx_core::node::SlowInputs;
use narx_core::units::{Celsius, Volts};

impl Plant {
    /// The slow inputs now: nominal rails, a board at rest, and what the plant simulates of the rest.
    pub fn slow_inputs(&self) -> SlowInputs {
        let milli = |value: f64| libm::round(value * 1000.0) as i32;
        let lines = self.lines();
        SlowInputs {
            ambient_temperature: Celsius::from_milli(milli(self.ambient())),
            external_temperature: Celsius::from_milli(milli(self.ambient())),
            pressure: Volts::from_milli(milli(self.pressure())),
            accel: [0, 0, 1000],
            accel_reference: Volts::from_milli(1_800),
            reference: Volts::from_milli(383),
            rail_6v: Volts::from_milli(6_000),
            rail_14v: Volts::from_milli(14_000),
            asi: Volts::ZERO,
            dsi1: lines.contains(Lines::DSI1),
            dsi2: lines.contains(Lines::DSI2),
        }
    }
}
