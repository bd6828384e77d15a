//! The drive's blocks, one by one. This file only converts numbers to fixed point and back.

use js_sys::{Array, Object};
use narx_core::blocks::{
    Commutation as CommutationCore, CommutationSettings, Hall as HallCore, HallSettings, Pi as PiCore,
    PiSettings, Position, Ramp as RampCore, RampSettings,
};
use narx_core::motor::Direction;
use narx_core::motor::gain::Gain;
use narx_wasm_values::error::{range_error, shown, whole};
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

/// Fixed point: 1 of a period or of a unit.
pub(crate) const ONE: f64 = 65_536.0;
/// Fixed point: a turn.
pub(crate) const TURN: f64 = 4_294_967_296.0;

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
        let settings = PiSettings {
            proportional: gain("proportional", options.required("proportional")?)?,
            integral: gain("integral", options.required("integral")?)?,
            step_rate: step_rate(&options)?,
            minimum: raw("minimum", options.required("minimum")?)?,
            maximum: raw("maximum", options.required("maximum")?)?,
        };
        PiCore::build(&settings).map(Self).map_err(|refused| range_error(&refused))
    }

    /// Returns the output for `error`.
    pub fn step(&mut self, error: f64) -> Result<f64, JsValue> {
        Ok(real(self.0.step(raw("error", error)?)))
    }

    /// Sets the integrator so that it alone gives `output`.
    pub fn hold(&mut self, output: f64) -> Result<(), JsValue> {
        self.0.hold(raw("output", output)?);
        Ok(())
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
        let rate = raw("rate", options.required("rate")?)?;
        let settings = RampSettings { rate, step_rate: step_rate(&options)? };
        RampCore::build(&settings).map(Self).map_err(|refused| range_error(&refused))
    }

    /// Moves one step towards `target`; returns the new value.
    pub fn step(&mut self, target: f64) -> Result<f64, JsValue> {
        Ok(real(self.0.step(raw("target", target)?)))
    }

    /// Continues from `value`.
    pub fn set(&mut self, value: f64) -> Result<(), JsValue> {
        self.0.set(raw("value", value)?);
        Ok(())
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
        let plain = HallSettings::default();
        let offset = options.number("offset")?.unwrap_or(0.0);
        let settings = HallSettings {
            tick_rate: options.whole("tickRate", 1e3, 1e5)?.map_or(plain.tick_rate, |rate| rate as u32),
            order: options.whole("order", 0.0, 5.0)?.unwrap_or(0.0) as u8,
            polarity: options.whole("polarity", 0.0, 7.0)?.unwrap_or(0.0) as u8,
            offset_cdeg: (offset * 100.0).round() as i32,
            captured: false,
            ..plain
        };
        HallCore::build(&settings).map(Self).map_err(|refused| range_error(&refused))
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
        set(&shaped, "angle", f64::from(reading.position.angle) * 360.0 / TURN);
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
    tick_rate: f64,
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
        let advance = whole("advance x 100", (advance.unwrap_or(0.0) * 100.0).round(), 0.0, 3000.0)?;
        let tick_rate = whole("tickRate", tick_rate.unwrap_or(10_000.0), 1.0, 1e6)?;
        // An eighth of a period: the time after which a drive has its answer.
        let settings = CommutationSettings { advance_cdeg: advance as u16, earliest: 8192 };
        let core = CommutationCore::build(&settings).map_err(|refused| range_error(&refused))?;
        Ok(Self { core, tick_rate })
    }

    /// Returns the step at the earliest instant of a period, and up to two changes later in it. `angle`:
    /// electrical degrees at the period's boundary. `speed`: electrical rev/s, negative in reverse.
    /// `reverse`: torque in reverse.
    #[wasm_bindgen(unchecked_return_type = "Pattern")]
    pub fn step(&mut self, angle: f64, speed: f64, reverse: Option<bool>) -> Result<Object, JsValue> {
        let most = self.tick_rate / 12.0;
        if !angle.is_finite() || speed.is_nan() || speed.abs() > most {
            let [angle, speed, most] = [angle, speed, most].map(|number| shown(&number.into()));
            return Err(range_error(&format!(
                "angle {angle} degrees, speed {speed} rev/s: must be finite, and at most {most} rev/s"
            )));
        }
        let position = Position {
            angle: ((angle / 360.0).rem_euclid(1.0) * TURN) as u64 as u32,
            speed: (speed / self.tick_rate * TURN).round() as i32,
        };
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

/// Converts a value to raw I16F16, rounded to nearest.
fn raw(name: &str, value: f64) -> Result<i32, JsValue> {
    if (-32_768.0..32_767.999_99).contains(&value) {
        return Ok((value * ONE).round() as i32);
    }
    let value = shown(&value.into());
    Err(range_error(&format!("{name} {value}: must be a finite number from -32768 to 32767.99998")))
}

pub(crate) fn real(raw: i32) -> f64 {
    f64::from(raw) / ONE
}

/// Returns the nearest gain of 30 bits.
fn gain(name: &str, value: f64) -> Result<Gain, JsValue> {
    let largest = f64::from(Gain::MANTISSA_MAX);
    let refused = || {
        let value = shown(&value.into());
        range_error(&format!("{name} {value}: must be 0, or from 2^-55 to 2^30"))
    };
    if !(0.0..=largest).contains(&value) {
        return Err(refused());
    }
    let mut shift: u8 = 62;
    let scaled = |shift: u8| (value * (1_u64 << shift) as f64).round();
    while shift > 0 && scaled(shift) > largest {
        shift -= 1;
    }
    Gain::new(scaled(shift) as i32, shift).ok_or_else(refused)
}
