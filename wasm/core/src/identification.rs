//! The identification of a motor, and the parameters for a motor that was identified.

use crate::master::Master;
use crate::requests::{NO_ANSWER, REFUSED, START, thrown};
use js_sys::{Array, JsString, Object};
use narx_core::commissioning::{Mode, Motor, Nameplate, WRITTEN};
use narx_core::dictionary::{Dictionary, engineering};
use narx_core::identification::{Asked, Figure, Identification as Core, IdentificationError, Identified};
use narx_core::motor::Board;
use narx_wasm_values::error::range_error;
use narx_wasm_values::options::{Options, set};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Facts that the user knows of the motor, and limits of its identification. */
export interface IdentificationOptions {
    /** Pole pairs, 1 to 50. They cannot be seen in volts and amperes: without them the rotor turns slowly, and `mark` counts. */
    polePairs?: number;
    /** Largest phase current, above 0 and at most 6 A; default the one whose heat in the winding is 6 W, 6 A at most. */
    current?: number;
    /** Resistance of two switches of the drive, 0 or more and below 1 ohm; default that of narx's own board, 0.04. It is taken off
     * what is measured. */
    bridge?: number;
    /** False holds the rotor and measures resistance and inductance alone; default true. */
    turn?: boolean;
    /** True calibrates the hall sensors, too; the drive keeps what it finds. Not with `turn: false`. Default false. */
    halls?: boolean;
}

/** Part of an identification: reads what the drive is; holds the rotor for resistance and inductance; turns it slowly
 * until its turns are marked, for the pole pairs; spins it and lets it coast
 * for the torque constant; accelerates it for inertia and friction; calibrates the hall sensors; stops it and restores the
 * parameters. */
export type IdentificationStage = "asking" | "holding" | "counting" | "spinning" | "accelerating" | "calibrating" | "restoring";

/** A measured figure. The truth is within `uncertainty` of `value` for about 95 of 100 motors. */
export interface Figure {
    readonly value: number;
    readonly uncertainty: number;
}

/** The figures of a motor as its drive has measured them, at the temperature that the motor had. */
export interface Identified {
    /** As given, or as counted. */
    readonly polePairs: number;
    /** Bus voltage without load, V. */
    readonly supplyVoltage: number;
    /** Largest phase current of the identification: the given one, or what the heat allows, A. */
    readonly current: number;
    /** Line to line, ohm. */
    readonly resistance: Figure;
    /** Line to line, H. */
    readonly inductance: Figure;
    /** Ambient temperature at the drive when the measurement began, degrees Celsius: that of a motor that has rested in the same
     * room. Absent if the drive does not broadcast it. */
    readonly temperature?: number;
    /** Figures of a rotor that has turned; absent if it was held. */
    readonly turned?: IdentifiedTurning;
    /** How the hall sensors are wired; absent if they were not asked for. */
    readonly halls?: IdentifiedHalls;
}

/** Wiring of hall sensors, as the drive's parameters have it from then on. */
export interface IdentifiedHalls {
    /** Permutation of the lines, 0 to 5 (parameter 262). */
    readonly order: number;
    /** Lines that are inverted, a bit each (parameter 263). */
    readonly polarity: number;
    /** Offset of the edges, electrical degrees (parameter 80). */
    readonly offset: number;
}

/** Figures that a rotor shows when it turns. */
export interface IdentifiedTurning {
    /** N m/A, which is the back-EMF constant, V s/rad. */
    readonly torqueConstant: Figure;
    /** Of the rotor and what is coupled to it, kg m2. */
    readonly inertia: Figure;
    /** Friction at `speed`, N m. */
    readonly friction: Figure;
    /** Its constant part, N m. */
    readonly staticFriction: number;
    /** Its part that grows with the speed, N m s/rad. */
    readonly viscousFriction: number;
    /** Speed to which `friction` belongs, rad/s. */
    readonly speed: number;
}

/** A motor, its supply and the control mode, for which a drive is commissioned. */
export interface CommissionOptions {
    /** Pole pairs, 1 to 255. */
    polePairs: number;
    /** Line to line, ohm. */
    resistance: number;
    /** Line to line, H. */
    inductance: number;
    /** N m/A. */
    torqueConstant: number;
    /** Of the rotor and what is coupled to it, kg m2. */
    inertia: number;
    /** Coulomb friction, N m; default 0. */
    staticFriction?: number;
    /** Viscous friction, N m s/rad; default 0. */
    viscousFriction?: number;
    /** Rated DC current, A; default what heats the winding by 6 W, at most 6 A. */
    ratedCurrent?: number;
    /** V. */
    supplyVoltage: number;
    mode: "hall" | "sensorless" | "open-loop";
    /** PWM frequency of the drive's board, 8000 to 50 000 Hz, a whole number; default 10 000. */
    pwmRate?: number;
}

/** Parameters for a motor, and what the drive's limits made of it. */
export interface Commissioned {
    /** Values by name, in their units: every parameter that a commissioning writes. */
    readonly parameters: Partial<Record<ParameterName, number>>;
    /** Limits of the drive that hold the motor back. */
    readonly notes: string[];
    /** Smallest and largest set-point, rpm. */
    readonly speedMin: number;
    readonly speedMax: number;
}
"#;

/// PWM frequencies of the boards, Hz.
const PWM_RATES: [f64; 2] = [8_000.0, 50_000.0];

/// The identification of a motor, step by step. It owns the requests, jobs and downloads of the master until
/// it ends. `drive.identify` of `narx/drive` waits for it.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Identification(Core);

#[wasm_bindgen]
impl Identification {
    /// Makes an identification that begins with the first step. The drive must be in Standby, with the shaft
    /// at rest. Throws for an invalid option.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(unchecked_param_type = "IdentificationOptions")] options: &JsValue,
    ) -> Result<Identification, JsValue> {
        let options =
            Options::new("identify", options, &["polePairs", "current", "bridge", "turn", "halls"])?;
        let pole_pairs = options.whole("polePairs", 1.0, 50.0)?;
        let plain = Asked::new(pole_pairs.map(|value| value as u8));
        let asked = Asked {
            current: options.number("current")?,
            bridge: options.number("bridge")?.unwrap_or(plain.bridge),
            turn: options.flag("turn")?.unwrap_or(plain.turn),
            halls: options.flag("halls")?.unwrap_or(plain.halls),
            ..plain
        };
        Core::new(asked).map(Self).map_err(|refused| range_error(&refused))
    }

    /// Part that is under way.
    #[wasm_bindgen(getter, unchecked_return_type = "IdentificationStage")]
    pub fn stage(&self) -> String {
        self.0.stage().name().to_owned()
    }

    /// Goes on, after every poll of the master; returns the figures once. Throws a `MasterError` with which
    /// the identification has ended.
    #[wasm_bindgen(unchecked_return_type = "Identified | undefined")]
    pub fn step(&mut self, master: &mut Master) -> Result<JsValue, JsValue> {
        match self.0.step(&mut master.core, master.now) {
            None => Ok(JsValue::UNDEFINED),
            Some(Ok(found)) => Ok(figures(&found).into()),
            Some(Err(error)) => Err(thrown_by(master, &error)),
        }
    }

    /// A mark on the shaft passes the same place as the last time: in the stage "counting" three of these
    /// tell the pole pairs. False, and nothing happens, at any other time.
    pub fn mark(&mut self, master: &Master) -> bool {
        self.0.mark(master.now)
    }

    /// Stops the motor; in the steps that follow the parameters get their former values, and the end is a
    /// "RefusedError".
    pub fn abort(&mut self, master: &mut Master) {
        self.0.abort(&mut master.core);
    }
}

fn thrown_by(master: &Master, error: &IdentificationError) -> JsValue {
    match *error {
        IdentificationError::Job(error) => master.job_error(error),
        IdentificationError::Request(..) | IdentificationError::Download(_) | IdentificationError::Lost => {
            thrown(NO_ANSWER, error)
        }
        IdentificationError::NotTaken(_) | IdentificationError::Aborted => thrown(REFUSED, error),
        _ => thrown(START, error),
    }
}

fn figures(found: &Identified) -> Object {
    let shaped = Object::new();
    set(&shaped, "polePairs", found.pole_pairs);
    set(&shaped, "supplyVoltage", found.supply);
    set(&shaped, "current", found.current);
    set(&shaped, "resistance", figure(found.resistance));
    set(&shaped, "inductance", figure(found.inductance));
    if let Some(temperature) = found.temperature {
        set(&shaped, "temperature", temperature);
    }
    if let Some(halls) = found.halls {
        let wired = Object::new();
        set(&wired, "order", halls.order);
        set(&wired, "polarity", halls.polarity);
        set(&wired, "offset", halls.offset);
        set(&shaped, "halls", wired);
    }
    if let Some(turned) = found.turned {
        let rotor = Object::new();
        set(&rotor, "torqueConstant", figure(turned.torque_constant));
        set(&rotor, "inertia", figure(turned.inertia));
        set(&rotor, "friction", figure(turned.friction));
        set(&rotor, "staticFriction", turned.static_friction);
        set(&rotor, "viscousFriction", turned.viscous_friction);
        set(&rotor, "speed", turned.speed);
        set(&shaped, "turned", rotor);
    }
    shaped
}

fn figure(figure: Figure) -> Object {
    let shaped = Object::new();
    set(&shaped, "value", figure.value);
    set(&shaped, "uncertainty", figure.uncertainty);
    shaped
}

/// Returns the parameters of a drive for a motor, by the design rules. Throws a `RangeError` for a motor or a
/// supply that the drive cannot run.
#[wasm_bindgen(unchecked_return_type = "Commissioned")]
pub fn commission(
    #[wasm_bindgen(unchecked_param_type = "CommissionOptions")] options: &JsValue,
) -> Result<JsValue, JsValue> {
    const NAMES: [&str; 11] = [
        "polePairs",
        "resistance",
        "inductance",
        "torqueConstant",
        "inertia",
        "staticFriction",
        "viscousFriction",
        "ratedCurrent",
        "supplyVoltage",
        "mode",
        "pwmRate",
    ];
    let options = Options::new("commission", options, &NAMES)?;
    options.required("polePairs")?;
    let [least, most] = PWM_RATES;
    let rate = options.whole("pwmRate", least, most)?;
    let board = rate.and_then(|rate| Board::BENCH.at_rate(rate as u32)).unwrap_or(Board::BENCH);
    let plate = Nameplate {
        motor: Motor {
            pole_pairs: options.whole("polePairs", 1.0, 255.0)?.unwrap_or_default() as u8,
            resistance: options.required("resistance")?,
            inductance: options.required("inductance")?,
            torque_constant: options.required("torqueConstant")?,
            inertia: options.required("inertia")?,
            static_friction: options.magnitude("staticFriction")?.unwrap_or(0.0),
            viscous_friction: options.magnitude("viscousFriction")?.unwrap_or(0.0),
        },
        rated_current: options.magnitude("ratedCurrent")?,
        supply: options.required("supplyVoltage")?,
        open_loop_speed: None,
    };
    let mode = options.choice("mode", &Mode::ALL.map(|mode| (mode.name(), mode)))?;
    let mode = mode.ok_or_else(|| options.missing("mode"))?;
    let found = plate.commission_on(&board, mode, None).map_err(|refused| range_error(&refused))?;
    let parameters = Object::new();
    for row in WRITTEN.into_iter().filter_map(Dictionary::row) {
        if let Some(value) = engineering::value(&found.parameters, row.number) {
            set(&parameters, row.name(), value);
        }
    }
    let shaped = Object::new();
    set(&shaped, "parameters", parameters);
    let notes: Array = found.notes.iter().map(|note| JsString::from(note.to_string())).collect();
    set(&shaped, "notes", notes);
    set(&shaped, "speedMin", found.speed_min);
    set(&shaped, "speedMax", found.speed_max);
    Ok(shaped.into())
}
