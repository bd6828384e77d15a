//! Motors: from a data sheet, or one of the presets.

use narx_sim::plant::{BackEmf, MotorConfig};
use narx_sim::presets::{self, PRESETS, Preset};
use narx_wasm_values::error::{list, shown, type_error};
use narx_wasm_values::options::Options;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Shape of the phase back-EMF against the rotor's angle. */
export type BackEmf = "trapezoidal" | "sinusoidal";

/** A star-connected three-phase motor with equal phases; resistance and inductance line to line, as data
 * sheets print them. */
export interface MotorOptions {
    /** Pole pairs, 1 to 255. */
    polePairs: number;
    /** Resistance line to line, ohm. */
    resistance: number;
    /** Inductance line to line, H. */
    inductance: number;
    /** Mean torque per DC ampere in ideal six-step, N m/A: 60 / (2 pi speed constant in rpm/V). */
    torqueConstant: number;
    /** Inertia of the rotor, kg m2. */
    inertia: number;
    /** Coulomb friction, N m; default 0. */
    staticFriction?: number;
    /** Viscous friction, N m s/rad; default 0. */
    viscousFriction?: number;
    /** Shape of the back-EMF; default "trapezoidal", with a flat top of 120 degrees. */
    backEmf?: BackEmf;
    /** Rated DC current, A, from which commissioning takes the current that the motor needs; default what
     * heats the winding by 6 W, at most 6 A. */
    ratedCurrent?: number;
}
"#;

const OPTIONS: [&str; 9] = [
    "polePairs",
    "resistance",
    "inductance",
    "torqueConstant",
    "inertia",
    "staticFriction",
    "viscousFriction",
    "backEmf",
    "ratedCurrent",
];

/// A motor, for one or more benches.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Motor {
    config: MotorConfig,
    rated_current: Option<f64>,
    preset: Option<&'static Preset>,
}

#[wasm_bindgen]
impl Motor {
    /// Makes a motor from its data sheet. Throws for a missing or invalid value.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(unchecked_param_type = "MotorOptions")] options: &JsValue,
    ) -> Result<Motor, JsValue> {
        let options = Options::new("Motor", options, &OPTIONS)?;
        let plain = MotorConfig::default();
        options.required("polePairs")?;
        let config = MotorConfig {
            pole_pairs: options.whole("polePairs", 1.0, 255.0)?.map_or(0, |pairs| pairs as u8),
            resistance: options.required("resistance")?,
            inductance: options.required("inductance")?,
            torque_constant: options.required("torqueConstant")?,
            inertia: options.required("inertia")?,
            static_friction: options.magnitude("staticFriction")?.unwrap_or(plain.static_friction),
            viscous_friction: options.magnitude("viscousFriction")?.unwrap_or(plain.viscous_friction),
            back_emf: options.choice("backEmf", &shapes())?.unwrap_or(plain.back_emf),
            ..plain
        };
        Ok(Self { config, rated_current: options.magnitude("ratedCurrent")?, preset: None })
    }

    /// Returns the names of the real motors that `preset` knows.
    #[wasm_bindgen(unchecked_return_type = "MotorName[]")]
    pub fn presets() -> Vec<String> {
        PRESETS.iter().map(|preset| preset.name.to_owned()).collect()
    }

    /// Returns a real motor by its name; `sim/src/presets/` has the source of every figure.
    pub fn preset(
        #[wasm_bindgen(unchecked_param_type = "MotorName")] name: &JsValue,
    ) -> Result<Motor, JsValue> {
        let found = name.as_string().and_then(|name| presets::preset(&name));
        let preset = found.ok_or_else(|| {
            let names = list(PRESETS.iter().map(|preset| preset.name));
            type_error(&format!("motor {}: no such preset; one of {names}", shown(name)))
        })?;
        Ok(Self { config: preset.motor, rated_current: preset.data.rated_current, preset: Some(preset) })
    }

    /// Maker of a preset.
    #[wasm_bindgen(getter)]
    pub fn maker(&self) -> Option<String> {
        self.preset.map(|preset| preset.maker.to_owned())
    }

    /// Part or order number of a preset.
    #[wasm_bindgen(getter)]
    pub fn part(&self) -> Option<String> {
        self.preset.map(|preset| preset.part.to_owned())
    }

    /// Nominal voltage of a preset, V.
    #[wasm_bindgen(getter, js_name = nominalVoltage)]
    pub fn nominal_voltage(&self) -> Option<f64> {
        self.preset.map(|preset| preset.data.nominal_voltage)
    }

    /// Pole pairs.
    #[wasm_bindgen(getter, js_name = polePairs)]
    pub fn pole_pairs(&self) -> u8 {
        self.config.pole_pairs
    }

    /// Resistance line to line, ohm.
    #[wasm_bindgen(getter)]
    pub fn resistance(&self) -> f64 {
        self.config.resistance
    }

    /// Inductance line to line, H.
    #[wasm_bindgen(getter)]
    pub fn inductance(&self) -> f64 {
        self.config.inductance
    }

    /// Mean torque per DC ampere in ideal six-step, N m/A.
    #[wasm_bindgen(getter, js_name = torqueConstant)]
    pub fn torque_constant(&self) -> f64 {
        self.config.torque_constant
    }

    /// Inertia of the rotor, kg m2.
    #[wasm_bindgen(getter)]
    pub fn inertia(&self) -> f64 {
        self.config.inertia
    }

    /// Coulomb friction, N m.
    #[wasm_bindgen(getter, js_name = staticFriction)]
    pub fn static_friction(&self) -> f64 {
        self.config.static_friction
    }

    /// Viscous friction, N m s/rad.
    #[wasm_bindgen(getter, js_name = viscousFriction)]
    pub fn viscous_friction(&self) -> f64 {
        self.config.viscous_friction
    }

    /// Rated DC current, A.
    #[wasm_bindgen(getter, js_name = ratedCurrent)]
    pub fn rated_current(&self) -> Option<f64> {
        self.rated_current
    }
}

impl Motor {
    /// Returns the motor's configuration for a bench.
    pub(crate) const fn config(&self) -> &MotorConfig {
        &self.config
    }
}

fn shapes() -> [(&'static str, BackEmf); 2] {
    [("trapezoidal", MotorConfig::default().back_emf), ("sinusoidal", BackEmf::Sinusoidal)]
}
