//! Changes to a bench: frames, faults, loads, inputs, further devices on its bus.

use crate::bench::{Bench, load};
use js_sys::{Array, Object};
use narx_core::bus::eddycan::{Channels, NodeId};
use narx_core::eddycan::Entry;
use narx_sim::plant::{Injection, InjectionKind, InjectionOptions, InjectionValue, Input, Phase};
use narx_sim::sensor::{EddyCurrentConfig, Encoder, Target};
use narx_sim::tx_driver::TxDriverConfig;
use narx_wasm_values::error::{list, range_error, shown, type_error};
use narx_wasm_values::frame;
use narx_wasm_values::options::{Options, set};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** A frame that has passed on the bus of a bench. */
export interface BusFrame extends Frame {
    readonly extended: boolean;
    readonly remote: boolean;
    /** Time of its end, s since power-up. */
    readonly time: number;
    /** True if it was sent by `send`, or by the bench's operator. */
    readonly sent: boolean;
}

/** Arguments of a fault; `Bench.injections` says which it takes. */
export interface InjectionOptions {
    value?: number;
    /** Phase, leg or hall line. */
    phase?: "A" | "B" | "C";
    /** Level of a hall line; default false. */
    high?: boolean;
}

/** A fault that can be injected, and the options that it takes. */
export interface InjectionKind {
    readonly name: InjectionName;
    /** Its value; absent if it takes none. The example is one that a drive with factory parameters does not
     * tolerate. */
    readonly value?: { readonly unit: string; readonly min: number; readonly max: number; readonly example: number };
    readonly phase: boolean;
    readonly high: boolean;
}

/** An eddyCAN TX-Driver on the bus and the shaft of a bench. */
export interface TxDriverOptions {
    /** Node-id, 1 to 127. */
    nodeId: number;
    /** Number of sensors; default 1. */
    channels?: 1 | 2;
    /** Counts per revolution of an incremental encoder on the shaft, 1 to 65 535; default none. */
    encoder?: number;
    /** Measuring range, mm; default 2. */
    measuringRange?: number;
}

/** An input of the board that is read slowly. */
export interface Input {
    readonly name: InputName;
    readonly unit: string;
    readonly min: number;
    readonly max: number;
}
"#;

const INJECTION_OPTIONS: [&str; 3] = ["value", "phase", "high"];
const TX_DRIVER_OPTIONS: [&str; 4] = ["nodeId", "channels", "encoder", "measuringRange"];
const PHASES: [(&str, Phase); 3] = [("A", Phase::A), ("B", Phase::B), ("C", Phase::C)];

#[wasm_bindgen]
impl Bench {
    /// Queues a frame at the host's place of the bus, with the present time. Throws a `RangeError` if 64
    /// frames wait already.
    pub fn send(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "Frame")] frame: &JsValue,
    ) -> Result<(), JsValue> {
        let frame = frame::parse(frame)?;
        self.core_mut().send(frame).map_err(|refused| range_error(&refused))
    }

    /// Returns the frames that have passed on the bus since the previous call, including those that were
    /// sent: at most the last 65 536. It returns none if frames are not kept.
    #[wasm_bindgen(js_name = takeFrames, unchecked_return_type = "BusFrame[]")]
    pub fn take_frames(&mut self) -> Array {
        let host = self.core().host();
        let received = self.frames.as_mut().map(std::mem::take).unwrap_or_default();
        let shape = |received: narx_sim::can::Received| {
            let shaped = frame::object(&received.frame);
            set(&shaped, "time", received.time_ns as f64 / 1e9);
            set(&shaped, "sent", received.sender == host);
            shaped
        };
        received.into_iter().map(shape).collect()
    }

    /// Injects a fault, until `clear`. A fault is a physical cause, not the fault bit that results from it.
    pub fn inject(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "InjectionName")] fault: &JsValue,
        #[wasm_bindgen(unchecked_optional_param_type = "InjectionOptions")] options: &JsValue,
    ) -> Result<(), JsValue> {
        let options = Options::new("inject", options, &INJECTION_OPTIONS)?;
        let injection = injection(fault, options.number("value")?, &options)?;
        self.core_mut().plant_mut().inject(injection);
        Ok(())
    }

    /// Removes one fault of `inject`, or all faults.
    pub fn clear(
        &mut self,
        #[wasm_bindgen(unchecked_optional_param_type = "InjectionName")] fault: &JsValue,
        #[wasm_bindgen(unchecked_optional_param_type = "InjectionOptions")] options: &JsValue,
    ) -> Result<(), JsValue> {
        if fault.is_undefined() {
            self.core_mut().plant_mut().clear_all();
            return Ok(());
        }
        let options = Options::new("clear", options, &INJECTION_OPTIONS)?;
        let value = Injection::some_value(&fault.as_string().unwrap_or_default());
        let injection = injection(fault, Some(value), &options)?;
        self.core_mut().plant_mut().clear(injection);
        Ok(())
    }

    /// Returns the faults that `inject` knows, and the options that each takes.
    #[wasm_bindgen(unchecked_return_type = "InjectionKind[]")]
    pub fn injections() -> Array {
        let shape = |kind: InjectionKind| {
            let shaped = Object::new();
            set(&shaped, "name", kind.name);
            if let Some(InjectionValue { unit, min, max, example }) = kind.value {
                let value = Object::new();
                set(&value, "unit", unit);
                set(&value, "min", min);
                set(&value, "max", max);
                set(&value, "example", example);
                set(&shaped, "value", value);
            }
            set(&shaped, "phase", kind.phase);
            set(&shaped, "high", kind.high);
            shaped
        };
        Injection::KINDS.into_iter().map(shape).collect()
    }

    /// Replaces the load on the shaft; commissioning is not repeated.
    #[wasm_bindgen(js_name = setLoad)]
    pub fn set_load(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "LoadOptions")] options: &JsValue,
    ) -> Result<(), JsValue> {
        let config = load(options)?;
        self.core_mut().plant_mut().set_load(config);
        Ok(())
    }

    /// Sets an input of the board to a value, in the unit of its measured quantity. Throws for a value that
    /// the input cannot have.
    #[wasm_bindgen(js_name = setInput)]
    pub fn set_input(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "InputName")] input: &JsValue,
        value: f64,
    ) -> Result<(), JsValue> {
        let found = input.as_string().and_then(|name| Input::named(&name)).ok_or_else(|| {
            let names = list(Input::ALL.map(Input::name));
            type_error(&format!("input {}: no such input; one of {names}", shown(input)))
        })?;
        let refused = |_| {
            let (min, max) = found.range();
            let [value, min, max] = [value, min, max].map(|number| shown(&number.into()));
            let (name, unit) = (found.name(), found.unit());
            range_error(&format!("input \"{name}\" {value} {unit}: must be {min} to {max} {unit}"))
        };
        self.core_mut().plant_mut().set_input(found, value).map_err(refused)
    }

    /// Powers up an eddyCAN TX-Driver on the drive's bus, in factory state. Its sensors measure the distance
    /// of the shaft's surface, a quarter of a revolution apart.
    #[wasm_bindgen(js_name = addTxDriver)]
    pub fn add_tx_driver(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "TxDriverOptions")] options: &JsValue,
    ) -> Result<(), JsValue> {
        let config = tx_driver(options)?;
        let node = config.configuration.node();
        if self.core().tx_drivers().iter().any(|device| device.driver().node() == node) {
            let message = format!("addTxDriver: nodeId {} is that of another TX-Driver", node.raw());
            return Err(range_error(&message));
        }
        let added = self.core_mut().add_tx_driver(&config);
        added.map(drop).map_err(|refused| range_error(&refused))
    }

    /// Returns the inputs of the board and their ranges.
    #[wasm_bindgen(unchecked_return_type = "Input[]")]
    pub fn inputs() -> Array {
        let shape = |input: Input| {
            let shaped = Object::new();
            let (min, max) = input.range();
            set(&shaped, "name", input.name());
            set(&shaped, "unit", input.unit());
            set(&shaped, "min", min);
            set(&shaped, "max", max);
            shaped
        };
        Input::ALL.into_iter().map(shape).collect()
    }
}

fn tx_driver(options: &JsValue) -> Result<TxDriverConfig, JsValue> {
    let options = Options::new("addTxDriver", options, &TX_DRIVER_OPTIONS)?;
    options.required("nodeId")?;
    let node = options.whole("nodeId", 1.0, 127.0)?.and_then(|node| NodeId::new(node as u8));
    let mut config = TxDriverConfig::new(node.unwrap_or(NodeId::FACTORY));
    if options.whole("channels", 1.0, 2.0)? == Some(2.0) {
        config.channels = Channels::Dual;
    }
    if let Some(range) = options.magnitude("measuringRange")? {
        config.sensors =
            [0.0, 90.0].map(|bearing| EddyCurrentConfig::new(range, Target::surface(range / 2.0, bearing)));
    }
    if let Some(counts) = options.whole("encoder", 1.0, u16::MAX.into())? {
        config.encoder = Some(Encoder::Rotary { counts: counts as u16 });
        // It cannot fail: the entry accepts every count of 16 bits.
        let _ = config.configuration.set(Entry::CountsPerRevolution, counts as u32);
    }
    Ok(config)
}

/// Returns a fault by its name.
fn injection(fault: &JsValue, value: Option<f64>, options: &Options) -> Result<Injection, JsValue> {
    let phase = options.choice("phase", &PHASES)?;
    let high = options.flag("high")?.unwrap_or(false);
    let name = fault.as_string().unwrap_or_default();
    Injection::named(&name, InjectionOptions { value, phase, high })
        .map_err(|refused| range_error(&format!("fault {}: {refused}", shown(fault))))
}
