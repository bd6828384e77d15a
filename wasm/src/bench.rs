//! A commissioned drive on a bench: set-up, commands and runs.

use crate::motor::Motor;
use js_sys::{Object, Reflect};
use narx_core::commissioning::{Commissioning, Mode};
use narx_core::dictionary::Dictionary;
use narx_sim::bench::Bench as Core;
use narx_sim::can::Received;
use narx_sim::plant::LoadConfig;
use narx_sim::session::{PWM_RATES, Session, SessionConfig, board_at};
use narx_wasm_values::error::{range_error, shown, type_error, whole};
use narx_wasm_values::options::Options;
use narx_wasm_values::trace::Trace;
use std::collections::VecDeque;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** A load on the shaft. All torques oppose the motion; the constant one also acts at standstill. All default
 * to 0. */
export interface LoadOptions {
    /** Constant torque, N m. */
    constant?: number;
    /** Torque proportional to the speed, N m s/rad. */
    viscous?: number;
    /** Torque proportional to the square of the speed, N m s2/rad2. */
    quadratic?: number;
    /** Inertia, rigidly coupled, kg m2. */
    inertia?: number;
}

/** Set-up of a bench and its drive: a plain object. The same options and calls give the same bits. */
export interface BenchOptions {
    /** Supply voltage, V. */
    supplyVoltage: number;
    load?: LoadOptions;
    /** Control mode; default "hall". */
    mode?: Mode;
    /** Speed of the mode "open-loop", rpm; default the slowest closed-loop speed. */
    openLoopSpeed?: number;
    /** Delay of the hall sensors' edges, electrical degrees, unknown to commissioning. Default 0. */
    hallOffset?: number;
    /** Parameters of the drive by name or number, in their units; they override those of commissioning. */
    parameters?: Record<string | number, number>;
    /** Ambient temperature, degrees Celsius; default 25. */
    ambient?: number;
    /** Seed of all noise, a whole number; default 1. */
    seed?: number;
    /** PWM frequency of the drive's board, Hz, a whole number from 8000 to 50 000; default 10 000. Every
     * period has one control tick. */
    pwmRate?: number;
    /** True if the bench has an operator of its own, which carries out `start`, `setSpeed` and `stop`;
     * default true. Without it, the drive is commanded by the frames of `send`. */
    operator?: boolean;
    /** Keep every frame of the bus for `takeFrames`; default true if there is no operator. */
    frames?: boolean;
    /** Record for `recording` and `digest`; default true. */
    recording?: boolean;
}
"#;

const OPTIONS: [&str; 12] = [
    "supplyVoltage",
    "load",
    "mode",
    "openLoopSpeed",
    "hallOffset",
    "parameters",
    "ambient",
    "seed",
    "pwmRate",
    "operator",
    "frames",
    "recording",
];
const LOAD_OPTIONS: [&str; 4] = ["constant", "viscous", "quadratic", "inertia"];
/// Largest speed of MOTOR_CMD, rpm.
const RPM_MAX: f64 = u16::MAX as f64;
/// Largest number below which every whole number is exact.
const SEED_MAX: f64 = 9_007_199_254_740_991.0;
/// Longest run of one call, s.
const RUN_MAX: f64 = 3600.0;
/// Largest number of frames that wait for `takeFrames`, some 17 s of a full bus; older ones are dropped.
const FRAMES_MAX: usize = 65_536;

/// A drive with its motor on a simulated bench. The same options and calls give the same bits.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct Bench {
    host: Host,
    /// Frames that were not taken yet; `None` if they are not kept.
    pub(crate) frames: Option<VecDeque<Received>>,
}

/// Device at the host's place of the bus.
#[derive(Clone, Debug)]
enum Host {
    /// An operator.
    Operator(Box<Session>),
    /// No device: the caller passes the frames.
    Nobody(Box<(Core, Commissioning)>),
}

#[wasm_bindgen]
impl Bench {
    /// Commissions the drive for the motor and powers it up; it stays in Standby until `start`. Throws for an
    /// invalid option.
    #[wasm_bindgen(constructor)]
    pub fn new(
        motor: &Motor,
        #[wasm_bindgen(unchecked_param_type = "BenchOptions")] options: &JsValue,
    ) -> Result<Bench, JsValue> {
        let options = Options::new("Bench", options, &OPTIONS)?;
        let config = config(motor, &options)?;
        let operator = options.flag("operator")?.unwrap_or(true);
        let recording = options.flag("recording")?.unwrap_or(true);
        let frames = options.flag("frames")?.unwrap_or(!operator).then(VecDeque::new);
        let host = if operator {
            let session = Session::new(&config).map_err(|refused| range_error(&refused))?;
            Host::Operator(Box::new(if recording { session } else { session.without_recording() }))
        } else {
            let (bench, commissioning) = config.power_up().map_err(|refused| range_error(&refused))?;
            let bench = if recording { bench } else { bench.without_recording() };
            Host::Nobody(Box::new((bench, commissioning)))
        };
        Ok(Self { host, frames })
    }

    /// Requests a speed through the operator, mechanical rpm, negative in reverse, and repeats it while time
    /// runs. The request waits for the drive's self-tests.
    pub fn start(&mut self, rpm: f64) -> Result<(), JsValue> {
        let rpm = whole("start", rpm, -RPM_MAX, RPM_MAX)?;
        self.operator("start")?.start(rpm as i32);
        Ok(())
    }

    /// Requests another speed through the operator, rpm, in the direction of `start`.
    #[wasm_bindgen(js_name = setSpeed)]
    pub fn set_speed(&mut self, rpm: f64) -> Result<(), JsValue> {
        let rpm = whole("setSpeed", rpm, 0.0, RPM_MAX)?;
        self.operator("setSpeed")?.set_speed(rpm as u16);
        Ok(())
    }

    /// Requests Standby through the operator, which also acknowledges a fault.
    pub fn stop(&mut self) -> Result<(), JsValue> {
        self.operator("stop")?.stop();
        Ok(())
    }

    /// Dismisses the operator: from here, the drive is commanded by the frames of `send`. Does nothing if
    /// there is none.
    pub fn dismiss(&mut self) {
        if let Host::Operator(session) = &self.host {
            let parts = (session.bench().clone(), session.commissioning().clone());
            self.host = Host::Nobody(Box::new(parts));
        }
    }

    /// Runs the simulation for `seconds`, to the nearest control tick, and returns the rows since the
    /// previous ones were taken, one for each tick. With `trace` false it keeps no rows, which is faster.
    pub fn run(&mut self, seconds: f64, trace: Option<bool>) -> Result<Trace, JsValue> {
        if !(0.0..=RUN_MAX).contains(&seconds) {
            let message =
                format!("run {}: must be 0 to {} s", shown(&seconds.into()), shown(&RUN_MAX.into()));
            return Err(range_error(&message));
        }
        self.core_mut().set_trace(trace.unwrap_or(true));
        let ticks = (seconds * f64::from(self.tick_rate())).round() as u64;
        (0..ticks).for_each(|_| self.tick());
        Ok(self.core_mut().take_trace().into())
    }

    /// Runs this many control ticks, default one. The next `takeTrace` or `run` returns their rows.
    pub fn step(&mut self, ticks: Option<u32>) {
        self.core_mut().set_trace(true);
        (0..ticks.unwrap_or(1)).for_each(|_| self.tick());
    }

    /// Returns the rows since the previous ones were taken.
    #[wasm_bindgen(js_name = takeTrace)]
    pub fn take_trace(&mut self) -> Trace {
        self.core_mut().take_trace().into()
    }

    /// Returns an independent copy of the bench in its present state, with motor, drive, bus and recording.
    /// Keep copies to return to an instant; the digest then continues as it would have from there.
    pub fn copy(&self) -> Self {
        self.clone()
    }
}

impl Bench {
    /// Returns the simulated bench.
    pub(crate) const fn core(&self) -> &Core {
        match &self.host {
            Host::Operator(session) => session.bench(),
            Host::Nobody(bench) => &bench.0,
        }
    }

    /// Returns the simulated bench, to change it.
    pub(crate) const fn core_mut(&mut self) -> &mut Core {
        match &mut self.host {
            Host::Operator(session) => session.bench_mut(),
            Host::Nobody(bench) => &mut bench.0,
        }
    }

    pub(crate) const fn commissioning(&self) -> &Commissioning {
        match &self.host {
            Host::Operator(session) => session.commissioning(),
            Host::Nobody(bench) => &bench.1,
        }
    }

    fn operator(&mut self, call: &str) -> Result<&mut Session, JsValue> {
        match &mut self.host {
            Host::Operator(session) => Ok(session),
            Host::Nobody(_) => Err(type_error(&format!(
                "{call}: this bench has no operator; its drive accepts frames (send)"
            ))),
        }
    }

    fn tick(&mut self) {
        match &mut self.host {
            Host::Operator(session) => session.step(),
            Host::Nobody(bench) => {
                bench.0.step();
                // Frames for the host itself are dropped: `monitor` returns all frames of the bus.
                while bench.0.receive().is_some() {}
            }
        }
        if self.frames.is_some() {
            self.monitor();
        }
    }

    fn monitor(&mut self) {
        while let Some(received) = self.core_mut().monitor() {
            if let Some(frames) = &mut self.frames {
                if frames.len() == FRAMES_MAX {
                    frames.pop_front();
                }
                frames.push_back(received);
            }
        }
    }
}

fn config(motor: &Motor, options: &Options) -> Result<SessionConfig, JsValue> {
    let mode = options.choice("mode", &Mode::ALL.map(|mode| (mode.name(), mode)))?;
    let supply = options.required("supplyVoltage")?;
    let mut config = SessionConfig::new(*motor.config(), supply, mode.unwrap_or(Mode::Hall));
    config.rated_current = motor.rated_current();
    let given = options.value("load")?.unwrap_or(JsValue::UNDEFINED);
    config.load = load(&given)?;
    config.open_loop_speed = options.magnitude("openLoopSpeed")?;
    config.hall_offset_deg = options.number("hallOffset")?.unwrap_or(config.hall_offset_deg);
    config.parameters = parameters(options)?;
    config.ambient = options.number("ambient")?.unwrap_or(config.ambient);
    config.seed = options.whole("seed", 0.0, SEED_MAX)?.map_or(config.seed, |seed| seed as u64);
    let [least, most] = [PWM_RATES.start(), PWM_RATES.end()].map(|rate| f64::from(*rate));
    if let Some(board) = options.whole("pwmRate", least, most)?.and_then(|rate| board_at(rate as u32)) {
        config.board = board;
    }
    Ok(config)
}

pub(crate) fn load(given: &JsValue) -> Result<LoadConfig, JsValue> {
    let load = Options::new("load", given, &LOAD_OPTIONS)?;
    Ok(LoadConfig {
        constant: load.magnitude("constant")?.unwrap_or(0.0),
        viscous: load.magnitude("viscous")?.unwrap_or(0.0),
        quadratic: load.magnitude("quadratic")?.unwrap_or(0.0),
        inertia: load.magnitude("inertia")?.unwrap_or(0.0),
        machine: 0.0,
    })
}

/// Returns parameters by number; a key that is not a number is a name of the dictionary.
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
