//! What may happen to a bench: frames, faults, loads, inputs, further devices on its bus.

use crate::bench::{Bench, load};
use js_sys::{Array, Object};
use narx_core::bus::eddycan::{Channels, NodeId};
use narx_core::eddycan::Entry;
use narx_sim::plant::{Injection, InjectionOptions, Input, Phase};
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
    /** End of the frame, s since power-up. */
    readonly time: number;
    /** It came by `send`, or from the bench's operator. */
    readonly sent: boolean;
}

/** What a fault is told besides its name. */
export interface InjectionOptions {
    /** "ambient" in degrees Celsius, "supply" and "pressure" in V, "leak" in ohm, "hall-glitches" per second. */
    value?: number;
    /** Of "driver", "open-phase", "hall-stuck" and "hall-swapped". */
    phase?: "A" | "B" | "C";
    /** Level of "hall-stuck"; default false. */
    high?: boolean;
}

/** An eddyCAN TX-Driver on the bus and the shaft of a bench. */
export interface TxDriverOptions {
    /** 1 to 127. */
    nodeId: number;
    /** Sensors of it; default 1. */
    channels?: 1 | 2;
    /** Counts per revolution of an incremental encoder on the shaft, 1 to 65 535; default none. */
    encoder?: number;
    /** mm; default 2. */
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
    /// Queues a frame at the host's place of the bus, as from now. Throws a `RangeError` where 64 of them wait already.
    pub fn send(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "Frame")] frame: &JsValue,
    ) -> Result<(), JsValue> {
        let frame = frame::parse(frame)?;
        self.core_mut().send(frame).map_err(|refused| range_error(&refused))
    }

    /// The frames that have passed on the bus since the last call, those that were sent among them; at most 65 536, the last ones. None if they are not kept.
    #[wasm_bindgen(js_name = takeFrames, unchecked_return_type = "BusFrame[]")]
    pub fn take_frames(&mut self) -> Array {
        let host = self.core().host();
        let heard = self.frames.as_mut().map(std::mem::take).unwrap_or_default();
        let shape = |heard: narx_sim::can::Received| {
            let shaped = frame::object(&heard.frame);
            set(&shaped, "time", heard.time_ns as f64 / 1e9);
            set(&shaped, "sent", heard.sender == host);
            shaped
        };
        heard.into_iter().map(shape).collect()
    }

    /// Breaks something, until `clear`: what has a physical cause, not the fault bit that comes of it.
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

    /// Mends one fault of `inject`, or everything.
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

    /// Names of what `inject` can break.
    #[wasm_bindgen(unchecked_return_type = "InjectionName[]")]
    pub fn injections() -> Vec<String> {
        Injection::NAMES.map(str::to_owned).to_vec()
    }

    /// Another load on the shaft from now on; commissioning does not know of it.
    #[wasm_bindgen(js_name = setLoad)]
    pub fn set_load(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "LoadOptions")] options: &JsValue,
    ) -> Result<(), JsValue> {
        let config = load(options)?;
        self.core_mut().plant_mut().set_load(config);
        Ok(())
    }

    /// Puts a value on an input of the board, in the unit of what it measures. Throws where no wire can carry it.
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

    /// Powers up an eddyCAN TX-Driver on the drive's bus, in factory state. Its sensors watch the shaft's surface, a quarter of a revolution apart.
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

    /// The inputs of the board and what they take.
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
        // Every count of 16 bits is one of the entry's values.
        let _ = config.configuration.set(Entry::CountsPerRevolution, counts as u32);
    }
    Ok(config)
}

/// A fault by its name.
fn injection(fault: &JsValue, value: Option<f64>, options: &Options) -> Result<Injection, JsValue> {
    let phase = options.choice("phase", &PHASES)?;
    let high = options.flag("high")?.unwrap_or(false);
    let name = fault.as_string().unwrap_or_default();
    Injection::named(&name, InjectionOptions { value, phase, high })
        .map_err(|refused| range_error(&format!("fault {}: {refused}", shown(fault))))
}
