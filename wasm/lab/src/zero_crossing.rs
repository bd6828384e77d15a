//! Zero crossings of the back-EMF. This file only converts numbers to fixed point and back.

use crate::blocks::{ONE, numbers};
use js_sys::{Array, Object};
use narx_core::blocks::engineering::{
    ADVANCE, BACK_EMF, BLANKING, Scale, VOLTS_PER_CODE, degrees, real, turn,
};
use narx_core::blocks::{
    CommutationSettings, ZeroCrossing as Core, ZeroCrossingReading as Reading, ZeroCrossingSettings,
};
use narx_core::motor::commutate::pwm::Commutation;
use narx_core::motor::guard::rails::Rail;
use narx_core::motor::rotor::zero_crossing::Why;
use narx_core::motor::sense::front_end::Channel;
use narx_core::motor::{Direction, PwmCommand, SampleMode, Samples, Step};
use narx_wasm_values::error::{range_error, type_error, whole};
use narx_wasm_values::options::{Options, set};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Settings of a `ZeroCrossing`. */
export interface ZeroCrossingOptions {
    /** Ticks a second, 1 000 to 100 000; default 10 000. */
    tickRate?: number;
    /** Scale of the converter to which voltages are rounded, V, up to 0.0625; default 0.019 531. */
    voltsPerCode?: number;
    /** Smallest signal, 1 to 255 codes; default 4. */
    noiseCodes?: number;
    /** Least time after a commutation, s (parameter 86); default 200e-6. */
    blanking?: number;
    /** Advance of the next commutation, electrical degrees, 0 to 30; default 0. */
    advance?: number;
    /** Line-to-line back-EMF, V a mechanical rpm (parameter 267); default 0: unknown. */
    backEmf?: number;
    /** Pole pairs, 1 to 100; default 1. */
    polePairs?: number;
    /** No crossing for this long is standstill, s (parameter 85); default 0.05. */
    timeout?: number;
}

/** Inputs of a `ZeroCrossing` for one period. */
export interface Terminals {
    /** Terminal voltages of A, B and C against ground, V. */
    phaseVoltage: readonly [number, number, number];
    /** Bus voltage, V. */
    busVoltage: number;
    /** Pattern that was in force in the period that has ended: the `Pattern` of the previous tick. */
    pattern: Pattern;
    /** True if sampled in the on-time, false in the off-time; default true. */
    onTime?: boolean;
    /** True for torque in reverse; default false. */
    reverse?: boolean;
}

/** Reading of the terminals after a tick. */
export interface ZeroCrossingReading {
    /** Age of a crossing that was seen in this tick: time from it to the present boundary, s; negative is
     * after the boundary. */
    readonly crossing?: number;
    /** Outcome of the last step's crossing. */
    readonly why: "none" | "accepted" | "filtered" | "blind" | "demag-late" | "listened";
    /** Lag of the last accepted crossing behind its prediction, electrical degrees. */
    readonly margin: number;
    /** Number of accepted crossings. */
    readonly accepted: number;
    /** Electrical angle, degrees, 0 to 360. */
    readonly angle: number;
    /** Electrical speed, rev/s, negative in reverse; 0 while unknown. */
    readonly speed: number;
    /** Time until the next commutation, s; absent while unknown. */
    readonly commutation?: number;
    /** Six consistent crossings were seen: the loop may be closed. */
    readonly running: boolean;
    /** Reason why the rotor was lost in this tick. */
    readonly lost?: "stall" | "desynchronised" | "wrong-lock";
}
"#;

const OPTIONS: [&str; 8] =
    ["tickRate", "voltsPerCode", "noiseCodes", "blanking", "advance", "backEmf", "polePairs", "timeout"];
const TERMINALS: [&str; 5] = ["phaseVoltage", "busVoltage", "pattern", "onTime", "reverse"];

/// The zero crossings of the drive: crossing, angle, speed and next commutation from the terminal voltages of
/// a driven or coasting motor. Align the rotor, call `start`, and commutate at the instants of the readings.
#[wasm_bindgen]
#[derive(Debug)]
pub struct ZeroCrossing {
    core: Core,
    volts_per_code: f64,
    tick_rate: f64,
}

#[wasm_bindgen]
impl ZeroCrossing {
    /// Makes a station that has not seen the motor yet. Throws for a setting out of range.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(unchecked_optional_param_type = "ZeroCrossingOptions")] options: &JsValue,
    ) -> Result<ZeroCrossing, JsValue> {
        let options = Options::new("ZeroCrossing", options, &OPTIONS)?;
        let number = |name, default: f64| Ok::<f64, JsValue>(options.number(name)?.unwrap_or(default));
        let tick_rate = options.whole("tickRate", 1e3, 1e5)?.unwrap_or(10_000.0);
        let noise_codes = options.whole("noiseCodes", 1.0, 255.0)?.unwrap_or(4.0) as u8;
        let pole_pairs = options.whole("polePairs", 1.0, 100.0)?.unwrap_or(1.0) as u16;
        let (volts_per_code, blanking) = (number("voltsPerCode", 0.019_531)?, number("blanking", 200e-6)?);
        let (advance, back_emf) = (number("advance", 0.0)?, number("backEmf", 0.0)?);
        let timeout = number("timeout", 0.05)?;
        numbers(|| {
            let micro_per_code = VOLTS_PER_CODE.setting("voltsPerCode", volts_per_code)?;
            let channel = Channel { zero: 0, micro_per_code };
            let plain = ZeroCrossingSettings::default();
            let core = Core::build(&ZeroCrossingSettings {
                tick_rate: tick_rate as u32,
                blanking_us: BLANKING.setting("blanking", blanking)?,
                back_emf_uv_per_rpm: BACK_EMF.setting("backEmf", back_emf)?,
                terminal: channel,
                bus_voltage: channel,
                commutation: CommutationSettings {
                    advance_cdeg: ADVANCE.setting("advance", advance)?,
                    ..plain.commutation
                },
                pole_pairs,
                timeout_ticks: Scale::zero_crossing_timeout(tick_rate).setting("timeout", timeout)?,
                noise_codes,
                ..plain
            })?;
            Ok(Self { core, volts_per_code: f64::from(micro_per_code) / 1e6, tick_rate })
        })
    }

    /// Begins to bring up a rotor that rests at `angle`, electrical degrees.
    pub fn start(&mut self, angle: f64, reverse: Option<bool>) -> Result<(), JsValue> {
        numbers(|| turn("angle", angle).map(|turn| self.core.start(turn, direction(reverse))))
    }

    /// Goes on by a step without any evidence: the rotor that is being brought up has not moved.
    #[wasm_bindgen(js_name = forceStep)]
    pub fn force_step(&mut self) {
        self.core.force_step();
    }

    /// Runs one tick.
    #[wasm_bindgen(unchecked_return_type = "ZeroCrossingReading")]
    pub fn step(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "Terminals")] terminals: &JsValue,
    ) -> Result<Object, JsValue> {
        let terminals = Options::new("step", terminals, &TERMINALS)?;
        let sample_mode =
            if terminals.flag("onTime")?.unwrap_or(true) { SampleMode::OnTime } else { SampleMode::OffTime };
        let phases =
            terminals.value("phaseVoltage")?.filter(JsValue::is_object).map(|value| Array::from(&value));
        let phases = phases.ok_or_else(|| type_error("step: phaseVoltage must be three numbers"))?;
        let mut phase_voltage = [0; 3];
        for (code, index) in phase_voltage.iter_mut().zip(0..) {
            *code = self.code("phaseVoltage", phases.get(index).as_f64())?;
        }
        let bus_voltage = self.code("busVoltage", terminals.number("busVoltage")?)?;
        let samples = Samples { phase_voltage, bus_voltage, sample_mode, ..Samples::default() };
        let applied = applied(&terminals, sample_mode)?;
        let reading = self.core.step(&samples, &applied, direction(terminals.flag("reverse")?));
        Ok(self.shape(&reading))
    }
}

impl ZeroCrossing {
    fn code(&self, name: &str, volts: Option<f64>) -> Result<u16, JsValue> {
        let volts = volts.filter(|volts| volts.is_finite());
        let volts = volts.ok_or_else(|| range_error(&format!("{name}: must be finite numbers, V")))?;
        Ok((volts / self.volts_per_code).round().clamp(0.0, 65_535.0) as u16)
    }

    fn shape(&self, reading: &Reading) -> Object {
        let seconds = |time: f64| time / ONE / self.tick_rate;
        let shaped = Object::new();
        if let Some(age) = reading.crossing {
            set(&shaped, "crossing", seconds(age.into()));
        }
        let why = match reading.why {
            Why::None => "none",
            Why::Accepted => "accepted",
            Why::Filtered => "filtered",
            Why::Blind => "blind",
            Why::DemagLate => "demag-late",
            Why::Listened => "listened",
        };
        set(&shaped, "why", why);
        set(&shaped, "margin", f64::from(reading.margin) * 360.0 / ONE);
        set(&shaped, "accepted", reading.accepted);
        set(&shaped, "angle", degrees(reading.position.angle));
        set(&shaped, "speed", real(reading.speed.to_bits()));
        if let Some(time) = reading.commutation {
            set(&shaped, "commutation", seconds(time.into()));
        }
        set(&shaped, "running", reading.running);
        let lost = match reading.lost {
            Rail::None => None,
            Rail::Stall => Some("stall"),
            Rail::Desynchronised => Some("desynchronised"),
            Rail::WrongLock => Some("wrong-lock"),
        };
        if let Some(lost) = lost {
            set(&shaped, "lost", lost);
        }
        shaped
    }
}

/// Returns the command that was applied in the period that has ended.
fn applied(terminals: &Options, sample_mode: SampleMode) -> Result<PwmCommand, JsValue> {
    let pattern = terminals.value("pattern")?;
    let pattern = pattern.ok_or_else(|| type_error("step: pattern is missing"))?;
    let pattern = Options::new("pattern", &pattern, &["step", "changes"])?;
    let mut applied = PwmCommand { step: pattern_step(&pattern)?, sample_mode, ..PwmCommand::default() };
    for change in pattern.value("changes")?.map(|changes| Array::from(&changes)).unwrap_or_default().iter() {
        let change = Options::new("change", &change, &["instant", "step"])?;
        let instant = whole("instant x 65536", (change.required("instant")? * ONE).round(), 0.0, 65_535.0)?;
        applied.commutations.push(Commutation { instant: instant as u16, step: pattern_step(&change)? });
    }
    Ok(applied)
}

fn pattern_step(options: &Options) -> Result<Step, JsValue> {
    let most = (Step::ALL.len() - 1) as f64;
    options.required("step")?;
    let number = options.whole("step", 0.0, most)?.unwrap_or_default();
    Ok(Step::ALL.get(number as usize).copied().unwrap_or_default())
}

fn direction(reverse: Option<bool>) -> Direction {
    if reverse.unwrap_or(false) { Direction::Reverse } else { Direction::Forward }
}
