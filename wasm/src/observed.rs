//! Observation of a bench.

use crate::bench::Bench;
use js_sys::{Array, Float64Array, Int8Array, Object};
use narx_core::commissioning::Mode;
use narx_core::motor::Cause;
use narx_sim::bench::SIGNALS;
use narx_sim::plant::Gate;
use narx_wasm_values::options::set;
use narx_wasm_values::trace::{signals, unknown};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Cause of the drive's stop. */
export interface Fault {
    /** Extended fault code. */
    readonly code: number;
    readonly meaning: string;
}

/** True values of an instant, which no drive can measure, and the state of the gates, for pictures. Arrays
 * are of phases A, B, C. */
export interface Observation {
    /** Time since power-up, s. */
    readonly time: number;
    /** Mechanical speed, rpm. */
    readonly speed: number;
    /** Mechanical angle of the shaft, rad, unwrapped. */
    readonly position: number;
    /** Electrical angle, degrees, 0 to 360; 0 is the rising zero crossing of phase A's back-EMF. */
    readonly angle: number;
    /** Phase currents into the motor, A. */
    readonly current: Float64Array;
    /** Terminal voltages against ground, V. */
    readonly voltage: Float64Array;
    /** Back-EMF against the star point, V. */
    readonly backEmf: Float64Array;
    /** Star point against ground, V. */
    readonly neutral: number;
    /** Bus voltage, V. */
    readonly busVoltage: number;
    /** Mean bus current of the last period, A. */
    readonly busCurrent: number;
    /** Mean torque of the last period, N m. */
    readonly torque: number;
    /** Conducting switch of each leg: 1 high, -1 low, 0 none. */
    readonly gates: Int8Array;
    /** Hall lines: bit 0 is A. */
    readonly hall: number;
    /** Pattern: 0 coast, 1 AB, 2 AC, 3 BC, 4 BA, 5 CA, 6 CB, more: rotor lock. */
    readonly step: number;
    /** Duty of this period, 0 to 1. */
    readonly duty: number;
}
"#;

#[wasm_bindgen]
impl Bench {
    /// Time since power-up, s.
    #[wasm_bindgen(getter)]
    pub fn time(&self) -> f64 {
        self.core().time()
    }

    /// Control ticks since power-up.
    #[wasm_bindgen(getter)]
    pub fn ticks(&self) -> f64 {
        self.core().plant().tick() as f64
    }

    /// Control ticks a second.
    #[wasm_bindgen(getter, js_name = tickRate)]
    pub fn tick_rate(&self) -> u32 {
        self.core().node().board().tick_rate
    }

    /// Returns the signals of every trace, and of `value`.
    #[wasm_bindgen(unchecked_return_type = "Signal[]")]
    pub fn signals() -> Array {
        signals(&SIGNALS)
    }

    /// Returns the present value of a signal.
    pub fn value(
        &self,
        #[wasm_bindgen(unchecked_param_type = "SignalName")] name: &JsValue,
    ) -> Result<f64, JsValue> {
        let text = name.as_string().unwrap_or_default();
        let index = SIGNALS.iter().position(|signal| signal.name == text);
        let value = index.and_then(|index| self.core().values().get(index).copied());
        value.ok_or_else(|| unknown(name, &SIGNALS))
    }

    /// Returns the present value of every signal, in the order of `signals()`.
    pub fn values(&self) -> Vec<f64> {
        self.core().values().to_vec()
    }

    /// Returns the true values of the present instant.
    #[wasm_bindgen(unchecked_return_type = "Observation")]
    pub fn observe(&self) -> Object {
        let plant = self.core().plant();
        let seen = plant.observe();
        let command = self.core().command();
        let shaped = Object::new();
        let numbers = [
            ("time", seen.time),
            ("speed", seen.speed * 60.0 / std::f64::consts::TAU),
            ("position", seen.angle),
            ("angle", (seen.electrical_turns - seen.electrical_turns.floor()) * 360.0),
            ("neutral", seen.neutral),
            ("busVoltage", seen.bus_voltage),
            ("busCurrent", seen.bus_current),
            ("torque", seen.torque),
            ("hall", f64::from(plant.hall())),
            ("step", f64::from(command.step as u8)),
            ("duty", f64::from(command.duty.to_bits()) / 32_768.0),
        ];
        for (name, number) in numbers {
            set(&shaped, name, number);
        }
        let phases = [("current", seen.current), ("voltage", seen.terminal), ("backEmf", plant.back_emf())];
        for (name, values) in phases {
            set(&shaped, name, Float64Array::from(values.as_slice()));
        }
        let gates = plant.gates().map(|gate| match gate {
            Gate::Off => 0,
            Gate::High => 1,
            Gate::Low => -1_i8,
        });
        set(&shaped, "gates", Int8Array::from(gates.as_slice()));
        shaped
    }

    /// State of the drive's state machine, 0 to 7.
    #[wasm_bindgen(getter)]
    pub fn state(&self) -> u8 {
        self.core().status().state as u8
    }

    /// Name of the state in the specification.
    #[wasm_bindgen(getter, js_name = stateName)]
    pub fn state_name(&self) -> String {
        self.core().status().state.name().to_owned()
    }

    /// Names of the bits of the fault word that are set.
    #[wasm_bindgen(getter, unchecked_return_type = "FaultName[]")]
    pub fn faults(&self) -> Vec<String> {
        self.core().status().faults.iter_names().map(|(name, _)| name.to_ascii_lowercase()).collect()
    }

    /// Cause of the drive's stop; `undefined` if it has not stopped.
    #[wasm_bindgen(getter, unchecked_return_type = "Fault | undefined")]
    pub fn fault(&self) -> JsValue {
        let code = self.core().status().extended_code;
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
        self.commissioning().speed_min
    }

    /// Largest set-point that commissioning gave the drive, rpm.
    #[wasm_bindgen(getter, js_name = speedMax)]
    pub fn speed_max(&self) -> f64 {
        self.commissioning().speed_max
    }

    /// Limits of the drive that restrict this motor, a sentence each.
    #[wasm_bindgen(getter)]
    pub fn notes(&self) -> Vec<String> {
        self.commissioning().notes.iter().map(ToString::to_string).collect()
    }

    /// Returns the recording of the drive since it last booted, for `replay` of `narx/lab` or a `.narxrec`
    /// file. It is empty if nothing is recorded.
    pub fn recording(&self) -> Vec<u8> {
        self.core().recording()
    }

    /// Returns the digest of all outputs of the drive since it last booted, as in its recording: 16
    /// lower-case hexadecimal digits.
    #[wasm_bindgen(getter)]
    pub fn digest(&self) -> String {
        format!("{:016x}", self.core().digest())
    }

    /// Returns the names of the control modes.
    #[wasm_bindgen(unchecked_return_type = "Mode[]")]
    pub fn modes() -> Vec<String> {
        Mode::ALL.iter().map(|mode| mode.name().to_owned()).collect()
    }
}
