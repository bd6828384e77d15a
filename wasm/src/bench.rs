//! A commissioned drive on a bench, with an operator who commands it over CAN.

use crate::error::{range_error, shown, type_error};
use crate::motor::Motor;
use crate::options::{Options, set};
use crate::trace::{Trace, signals, unknown};
use js_sys::{Array, Object, Reflect};
use narx_core::dictionary::Dictionary;
use narx_core::motor::Cause;
use narx_sim::bench::SIGNALS;
use narx_sim::commissioning::Mode;
use narx_sim::plant::LoadConfig;
use narx_sim::session::{Session, SessionConfig};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** A load on the shaft. All torques oppose the motion; the constant one also holds at standstill. All default to 0. */
export interface LoadOptions {
    /** N m. */
    constant?: number;
    /** N m s/rad. */
    viscous?: number;
    /** N m s2/rad2. */
    quadratic?: number;
    /** kg m2, rigidly coupled. */
    inertia?: number;
}

/** What is on the bench, and how the drive is set up. */
export interface BenchOptions {
    /** V. */
    supplyVoltage: number;
    load?: LoadOptions;
    /** Control mode; default "hall". */
    mode?: Mode;
    /** Speed of the mode "open-loop", rpm; default the slowest closed-loop speed. */
    openLoopSpeed?: number;
    /** Parameters of the drive by name or number, in their units; they win over those of commissioning. */
    parameters?: Record<string | number, number>;
    /** Degrees Celsius; default 25. */
    ambient?: number;
    /** Seed of all noise, a whole number; default 1. */
    seed?: number;
}

/** Why the drive stopped. */
export interface Fault {
    /** Extended fault code. */
    readonly code: number;
    readonly meaning: string;
}
"#;

const OPTIONS: [&str; 7] =
    ["supplyVoltage", "load", "mode", "openLoopSpeed", "parameters", "ambient", "seed"];
const LOAD_OPTIONS: [&str; 4] = ["constant", "viscous", "quadratic", "inertia"];
/// Above this a number no longer counts one by one.
const SEED_MAX: f64 = 9_007_199_254_740_991.0;
/// One call must end in reasonable time, s.
const RUN_MAX: f64 = 3600.0;

/// A drive with its motor on a simulated bench. Same options and calls, same bits.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Bench(Session);

#[wasm_bindgen]
impl Bench {
    /// Commissions the drive for the motor and powers it up; it stays in Standby until `start`. Throws where an
    /// option cannot be.
    #[wasm_bindgen(constructor)]
    pub fn new(
        motor: &Motor,
        #[wasm_bindgen(unchecked_param_type = "BenchOptions")] options: &JsValue,
    ) -> Result<Bench, JsValue> {
        let options = Options::new("Bench", options, &OPTIONS)?;
        let mode = options.choice("mode", &Mode::ALL.map(|mode| (mode.name(), mode)))?;
        let supply = options.required("supplyVoltage")?;
        let mut config = SessionConfig::new(*motor.config(), supply, mode.unwrap_or(Mode::Hall));
        config.rated_current = motor.rated_current();
        config.load = load(&options)?;
        config.open_loop_speed = options.magnitude("openLoopSpeed")?;
        config.parameters = parameters(&options)?;
        config.ambient = options.number("ambient")?.unwrap_or(config.ambient);
        config.seed = options.whole("seed", 0.0, SEED_MAX)?.map_or(config.seed, |seed| seed as u64);
        Session::new(&config).map(Self).map_err(|refused| range_error(&refused))
    }

    /// The operator asks for a speed, mechanical rpm, negative in reverse, and repeats it while time runs.
    pub fn start(&mut self, rpm: f64) -> Result<(), JsValue> {
        let rpm = magnitude("start", rpm, -f64::from(u16::MAX))?;
        self.0.master().start(rpm as i32);
        Ok(())
    }

    /// The operator asks for another speed, rpm, in the direction of `start`.
    #[wasm_bindgen(js_name = setSpeed)]
    pub fn set_speed(&mut self, rpm: f64) -> Result<(), JsValue> {
        let rpm = magnitude("setSpeed", rpm, 0.0)?;
        self.0.master().set_speed(rpm as u16);
        Ok(())
    }

    /// The operator asks for Standby.
    pub fn stop(&mut self) {
        self.0.master().stop();
    }

    /// Lets time run, to the nearest control tick, and returns the rows of this run.
    pub fn run(&mut self, seconds: f64) -> Result<Trace, JsValue> {
        if !(0.0..=RUN_MAX).contains(&seconds) {
            let message =
                format!("run {}: must be 0 to {} s", shown(&seconds.into()), shown(&RUN_MAX.into()));
            return Err(range_error(&message));
        }
        self.0.run(seconds);
        Ok(self.0.bench_mut().take_trace().into())
    }

    /// Time since power-up, s.
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.0.bench().time()
    }

    /// Signals of every trace, and of `value`.
    #[wasm_bindgen(unchecked_return_type = "Signal[]")]
    pub fn signals() -> Array {
        signals(&SIGNALS)
    }

    /// The present value of a signal.
    pub fn value(
        &self,
        #[wasm_bindgen(unchecked_param_type = "SignalName")] name: &JsValue,
    ) -> Result<f64, JsValue> {
        let text = name.as_string().unwrap_or_default();
        let index = SIGNALS.iter().position(|signal| signal.name == text);
        let value = index.and_then(|index| self.0.bench().values().get(index).copied());
        value.ok_or_else(|| unknown(name, &SIGNALS))
    }

    /// The present value of every signal, in the order of `signals()`.
    pub fn values(&self) -> Vec<f64> {
        self.0.bench().values().to_vec()
    }

    /// State of the drive's state machine, 0 to 7.
    #[wasm_bindgen(getter)]
    pub fn state(&self) -> u8 {
        self.0.bench().status().state as u8
    }

    /// Name of the state in the specification.
    #[wasm_bindgen(getter, js_name = stateName)]
    pub fn state_name(&self) -> String {
        self.0.bench().status().state.name().to_owned()
    }

    /// Names of the bits of the fault word that are set.
    #[wasm_bindgen(getter, unchecked_return_type = "FaultName[]")]
    pub fn faults(&self) -> Vec<String> {
        self.0.bench().status().faults.iter_names().map(|(name, _)| name.to_ascii_lowercase()).collect()
    }

    /// Why the drive stopped, if it did.
    #[wasm_bindgen(getter, unchecked_return_type = "Fault | undefined")]
    pub fn fault(&self) -> JsValue {
        let code = self.0.bench().status().extended_code;
        let Some(row) = Cause::TABLE.iter().find(|row| row.cause as u16 == code) else {
            return JsValue::UNDEFINED;
        };
        let fault = Object::new();
        set(&fault, "code", code);
        set(&fault, "meaning", row.meaning);
        fault.into()
    }

    /// Smallest set-point that commissioning gave the drive, rpm.
    #[wasm_bindgen(getter, js_name = speedMin)]
    pub fn speed_min(&self) -> f64 {
        self.0.commissioning().speed_min
    }

    /// Largest set-point that commissioning gave the drive, rpm.
    #[wasm_bindgen(getter, js_name = speedMax)]
    pub fn speed_max(&self) -> f64 {
        self.0.commissioning().speed_max
    }

    /// Where a limit of the drive holds the motor back, in words.
    #[wasm_bindgen(getter)]
    pub fn notes(&self) -> Vec<String> {
        self.0.commissioning().notes.iter().map(ToString::to_string).collect()
    }

    /// Recording of the drive since it last booted: what `replay` takes, and a `.narxrec` file holds.
    pub fn recording(&self) -> Vec<u8> {
        self.0.bench().recording()
    }

    /// Control modes.
    #[wasm_bindgen(unchecked_return_type = "Mode[]")]
    pub fn modes() -> Vec<String> {
        Mode::ALL.iter().map(|mode| mode.name().to_owned()).collect()
    }
}

fn load(options: &Options) -> Result<LoadConfig, JsValue> {
    let given = options.value("load")?.unwrap_or(JsValue::UNDEFINED);
    let load = Options::new("load", &given, &LOAD_OPTIONS)?;
    Ok(LoadConfig {
        constant: load.magnitude("constant")?.unwrap_or(0.0),
        viscous: load.magnitude("viscous")?.unwrap_or(0.0),
        quadratic: load.magnitude("quadratic")?.unwrap_or(0.0),
        inertia: load.magnitude("inertia")?.unwrap_or(0.0),
    })
}

/// Parameters by number; a key that is not a number is a name of the dictionary.
fn parameters(options: &Options) -> Result<Vec<(u16, f64)>, JsValue> {
    let Some(given) = options.value("parameters")? else { return Ok(Vec::new()) };
    if !given.is_object() {
        return Err(type_error(&format!("parameters must be an object, not {}", shown(&given))));
    }
    let keys = Object::keys(given.unchecked_ref::<Object>());
    let pair = |key: JsValue| {
        let name = key.as_string().unwrap_or_default();
        let number = name.parse().ok().or(Dictionary::find(&name).map(|row| row.number));
        let number = number.ok_or_else(|| type_error(&format!("there is no parameter \"{name}\"")))?;
        let value = Reflect::get(&given, &key)?;
        let refused = || type_error(&format!("parameter \"{name}\" {}: must be a number", shown(&value)));
        Ok((number, value.as_f64().ok_or_else(refused)?))
    };
    keys.iter().map(pair).collect()
}

/// What a MOTOR_CMD can carry: whole rpm of 16 bits.
fn magnitude(call: &str, rpm: f64, min: f64) -> Result<f64, JsValue> {
    let max = f64::from(u16::MAX);
    if rpm.fract() == 0.0 && (min..=max).contains(&rpm) {
        return Ok(rpm);
    }
    let [rpm, min, max] = [rpm, min, max].map(|number| shown(&number.into()));
    Err(range_error(&format!("{call} {rpm}: must be a whole number from {min} to {max} rpm")))
}
