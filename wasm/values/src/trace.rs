//! Results of a run, as typed arrays.

use crate::error::{list, shown, type_error};
use crate::options::set;
use js_sys::{Array, Float32Array, Float64Array, Object};
use narx_sim::trace::{self, Column};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Name and unit of a signal; the unit of a plain number is empty. */
export interface Signal {
    readonly name: SignalName;
    readonly unit: string;
}
"#;

/// Named signals, one row per control tick.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Trace(trace::Trace);

#[wasm_bindgen]
impl Trace {
    /// Number of rows.
    #[wasm_bindgen(getter)]
    pub fn length(&self) -> usize {
        self.0.len()
    }

    /// Returns the signals in the order of the columns of `run.csv`.
    #[wasm_bindgen(getter, unchecked_return_type = "Signal[]")]
    pub fn signals(&self) -> Array {
        signals(self.0.signals())
    }

    /// Time of each row since power-up, s.
    #[wasm_bindgen(getter, unchecked_return_type = "Float64Array")]
    pub fn time(&self) -> Result<JsValue, JsValue> {
        self.column(&"time".into())
    }

    /// Returns a copy of the values of one signal: 64 bits for time and counts, 32 for measured values.
    #[wasm_bindgen(unchecked_return_type = "Float32Array | Float64Array")]
    pub fn column(
        &self,
        #[wasm_bindgen(unchecked_param_type = "SignalName")] name: &JsValue,
    ) -> Result<JsValue, JsValue> {
        match name.as_string().and_then(|name| self.0.column(&name)) {
            Some(Column::Single(values)) => Ok(Float32Array::from(values.as_slice()).into()),
            Some(Column::Double(values)) => Ok(Float64Array::from(values.as_slice()).into()),
            None => Err(unknown(name, self.0.signals())),
        }
    }
}

impl From<trace::Trace> for Trace {
    fn from(trace: trace::Trace) -> Self {
        Self(trace)
    }
}

/// Converts signals for JavaScript.
pub fn signals(signals: &[trace::Signal]) -> Array {
    let shape = |signal: &trace::Signal| {
        let shaped = Object::new();
        set(&shaped, "name", signal.name);
        set(&shaped, "unit", signal.unit);
        shaped
    };
    signals.iter().map(shape).collect()
}

/// Returns the error for a signal name that does not exist.
pub fn unknown(name: &JsValue, signals: &[trace::Signal]) -> JsValue {
    let names = list(signals.iter().map(|signal| signal.name));
    type_error(&format!("signal {}: no such signal; one of {names}", shown(name)))
}
