//! The drive's blocks, one by one. This file only converts numbers to fixed point and back.

use js_sys::{Array, Object};
use narx_core::blocks::engineering::{ADVANCE, HALL_OFFSET, NumberError, degrees, gain, position, raw, real};
use narx_core::blocks::{
    Commutation as CommutationCore, CommutationSettings, Hall as HallCore, HallSettings, Pi as PiCore,
    PiSettings, Ramp as RampCore, RampSettings,
};
use narx_core::motor::Direction;
use narx_wasm_values::error::{range_error, whole};
use narx_wasm_values::options::{Options, set};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Settings of a `Pi`. Error and output have units of the caller's choice, within +-32 767. */
export interface PiOptions {
    /** Kp: output per error. */
    proportional: number;
    /** Ki: output per error and second. */
    integral: number;
    /** Steps a second; default 10 000. */
    stepRate?: number;
    minimum: number;
    maximum: number;
}

/** Settings of a `Ramp`. */
export interface RampOptions {
    /** Steepest change, a second. */
    rate: number;
    /** Steps a second; default 10 000. */
    stepRate?: number;
}

/** Settings of a `Hall`. */
export interface HallOptions {
    /** Ticks a second; default 10 000. */
    tickRate?: number;
    /** Permutation of the lines, 0 to 5 (parameter 262); default 0. */
    order?: number;
    /** Lines to invert, 0 to 7 (parameter 263); default 0. */
    polarity?: number;
    /** Offset of the edges beyond their place, electrical degrees (parameter 80); default 0. */
    offset?: number;
}

/** Reading of the hall sensors after a tick. */
export interface HallReading {
    /** Sector, 0 to 5: sector s spans 30 + 60 s to 90 + 60 s degrees; absent until the first valid code. */
    readonly sector?: number;
    /** Electrical angle, degrees, 0 to 360. */
    readonly angle: number;
    /** Electrical speed, rev/s, negative in reverse. */
    readonly speed: number;
    readonly invalid: boolean;
    readonly jump: boolean;
    readonly stopped: boolean;
    readonly doubtful: boolean;
}

/** Result of a commutation: the step of a period, and its changes within it. Steps are numbered as
 * `Observation.step`. */
export interface Pattern {
    readonly step: number;
    readonly changes: readonly { /** In periods. */ readonly instant: number; readonly step: number }[];
}
"#;

/// Raw value of a period.
pub(crate) const ONE: f64 = 65_536.0;

/// A PI controller of the drive: u = Kp e + integral of Ki e dt, within its limits, bit for bit.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Pi(PiCore);

#[wasm_bindgen]
impl Pi {
    /// Makes a controller at rest. Throws for a setting out of range.
    #[wasm_bindgen(constructor)]
    pub fn new(#[wasm_bindgen(unchecked_param_type = "PiOptions")] options: &JsValue) -> Result<Pi, JsValue> {
        let names = ["proportional", "integral", "stepRate", "minimum", "maximum"];
        let options = Options::new("Pi", options, &names)?;
        let [proportional, integral, minimum, maximum] = [
            options.required("proportional")?,
            options.required("integral")?,
            options.required("minimum")?,
            options.required("maximum")?,
        ];
        let step_rate = step_rate(&options)?;
        numbers(|| {
            Ok(Self(PiCore::build(&PiSettings {
                proportional: gain("proportional", proportional)?,
                integral: gain("integral", integral)?,
                step_rate,
                minimum: raw("minimum", minimum, "")?,
                maximum: raw("maximum", maximum, "")?,
            })?))
        })
    }

    /// Returns the output for `error`.
    pub fn step(&mut self, error: f64) -> Result<f64, JsValue> {
        numbers(|| Ok(real(self.0.step(raw("error", error, "")?))))
    }

    /// Sets the integrator so that it alone gives `output`.
    pub fn hold(&mut self, output: f64) -> Result<(), JsValue> {
        numbers(|| raw("output", output, "").map(|output| self.0.hold(output)))
    }
}

/// A ramp of the drive: a value that approaches its target by at most a rate.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Ramp(RampCore);

#[wasm_bindgen]
impl Ramp {
    /// Makes a ramp at 0. Throws for a setting out of range.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(unchecked_param_type = "RampOptions")] options: &JsValue,
    ) -> Result<Ramp, JsValue> {
        let options = Options::new("Ramp", options, &["rate", "stepRate"])?;
        let (rate, step_rate) = (options.required("rate")?, step_rate(&options)?);
        numbers(|| Ok(Self(RampCore::build(&RampSettings { rate: raw("rate", rate, "")?, step_rate })?)))
    }

    /// Moves one step towards `target`; returns the new value.
    pub fn step(&mut self, target: f64) -> Result<f64, JsValue> {
        numbers(|| Ok(real(self.0.step(raw("target", target, "")?))))
    }

    /// Continues from `value`.
    pub fn set(&mut self, value: f64) -> Result<(), JsValue> {
        numbers(|| raw("value", value, "").map(|value| self.0.set(value)))
    }
}

/// The hall sensors of the drive: sector, angle and speed from codes. Only the level is read, once a tick.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Hall(HallCore);

#[wasm_bindgen]
impl Hall {
    /// Makes a station that has not seen the sensors yet. Throws for a setting out of range.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(unchecked_optional_param_type = "HallOptions")] options: &JsValue,
    ) -> Result<Hall, JsValue> {
        let options = Options::new("Hall", options, &["tickRate", "order", "polarity", "offset"])?;
        let tick_rate = options.whole("tickRate", 1e3, 1e5)?.unwrap_or(10_000.0) as u32;
        let order = options.whole("order", 0.0, 5.0)?.unwrap_or(0.0) as u8;
        let polarity = options.whole("polarity", 0.0, 7.0)?.unwrap_or(0.0) as u8;
        let offset = options.number("offset")?.unwrap_or(0.0);
        numbers(|| {
            let offset_cdeg = HALL_OFFSET.setting("offset", offset)?;
            let plain = HallSettings::default();
            let settings = HallSettings { tick_rate, order, polarity, offset_cdeg, captured: false, ..plain };
            Ok(Self(HallCore::build(&settings)?))
        })
    }

    /// Runs one tick. `code`: the lines now, bit 0 is A.
    #[wasm_bindgen(unchecked_return_type = "HallReading")]
    pub fn step(&mut self, code: f64) -> Result<Object, JsValue> {
        let code = whole("code", code, 0.0, 7.0)? as u8;
        let reading = self.0.step(code, &[]);
        let shaped = Object::new();
        if let Some(sector) = reading.sector {
            set(&shaped, "sector", sector);
        }
        set(&shaped, "angle", degrees(reading.position.angle));
        set(&shaped, "speed", real(reading.speed.to_bits()));
        set(&shaped, "invalid", reading.events.invalid);
        set(&shaped, "jump", reading.events.jump);
        set(&shaped, "stopped", reading.stopped);
        set(&shaped, "doubtful", reading.doubtful);
        Ok(shaped)
    }
}

/// The commutation of the drive: steps of the bridge from a rotor's position.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Commutation {
    core: CommutationCore,
    tick_rate: u32,
}

#[wasm_bindgen]
impl Commutation {
    /// Makes a commutation that knows no rotor position yet. `advance`: timing advance, electrical degrees, 0
    /// to 30; default 0. `tickRate`: default 10 000.
    #[wasm_bindgen(constructor)]
    pub fn new(
        advance: Option<f64>,
        #[wasm_bindgen(js_name = tickRate)] tick_rate: Option<f64>,
    ) -> Result<Commutation, JsValue> {
        let tick_rate = whole("tickRate", tick_rate.unwrap_or(10_000.0), 1.0, 1e6)? as u32;
        numbers(|| {
            let advance_cdeg = ADVANCE.setting("advance", advance.unwrap_or(0.0))?;
            // An eighth of a period: the time after which a drive has its answer.
            let core = CommutationCore::build(&CommutationSettings { advance_cdeg, earliest: 8192 })?;
            Ok(Self { core, tick_rate })
        })
    }

    /// Returns the step at the earliest instant of a period, and up to two changes later in it. `angle`:
    /// electrical degrees at the period's boundary. `speed`: electrical rev/s, negative in reverse.
    /// `reverse`: torque in reverse.
    #[wasm_bindgen(unchecked_return_type = "Pattern")]
    pub fn step(&mut self, angle: f64, speed: f64, reverse: Option<bool>) -> Result<Object, JsValue> {
        let position = numbers(|| position(angle, speed, self.tick_rate))?;
        let torque = if reverse.unwrap_or(false) { Direction::Reverse } else { Direction::Forward };
        let (step, changes) = self.core.step(position, torque);
        let change = |change: narx_core::motor::Commutation| {
            let shaped = Object::new();
            set(&shaped, "instant", f64::from(change.instant) / ONE);
            set(&shaped, "step", change.step as u8);
            shaped
        };
        let shaped = Object::new();
        set(&shaped, "step", step as u8);
        set(&shaped, "changes", changes.iter().map(change).collect::<Array>());
        Ok(shaped)
    }
}

fn step_rate(options: &Options) -> Result<u32, JsValue> {
    Ok(options.whole("stepRate", 1.0, 1e6)?.map_or(10_000, |rate| rate as u32))
}

/// Runs what takes numbers; one that is out of range becomes a `RangeError`, which names it.
pub(crate) fn numbers<'a, T>(run: impl FnOnce() -> Result<T, NumberError<'a>>) -> Result<T, JsValue> {
    run().map_err(|error| range_error(&error))
}
