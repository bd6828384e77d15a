//! Logs of a bus as columns.

use js_sys::{Array, Float64Array, Object, Reflect, Uint8Array, Uint32Array};
use narx_core::bus::narmotion::Addresses;
use narx_host::can_log::{CanLog, Config, Ends, Frames, Kind, LineError, Table, Values, flag};
use narx_wasm_values::error::{type_error, whole};
use narx_wasm_values::options::{Options, set};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Addresses and nodes whose messages are decoded. */
export interface LogOptions {
    /** Address of the drive; default 170, `null` for any. */
    slave?: number | null;
    /** Address of its master; default 85, `null` for any. */
    monitor?: number | null;
    /** Node-ids of TX-Drivers whose PDOs of 8 bytes carry the encoder. */
    encoders?: readonly number[];
}

/** Every message of one kind: columns of the same length. */
export interface MessageTable {
    /** Name in the CAN database or in Table 3 of the eddyCAN specification. */
    readonly name: MessageName;
    /** True if a drive or node sends it, false if its master does. */
    readonly fromDevice: boolean;
    /** Time stamps, s. */
    readonly time: Float64Array;
    /** Values by signal, in its unit. Named values are numbers; NaN if a message does not carry the
     * signal. */
    readonly columns: Readonly<Record<string, Float64Array>>;
    /** Units by signal; empty for plain numbers. */
    readonly units: Readonly<Record<string, string>>;
    /** Names of a signal's numbers, by signal, for signals that have names. */
    readonly names: Readonly<Record<string, Readonly<Record<number, string>>>>;
}

/** A log as columns. Every line is a frame, blank, or an error. */
export interface CanLog {
    readonly lines: number;
    /** All frames. */
    readonly frames: {
        /** Time stamps, s. */
        readonly time: Float64Array;
        readonly id: Uint32Array;
        /** Bits: 1 29-bit identifier, 2 remote, 4 error frame, 8 CAN FD, 16 received. */
        readonly flags: Uint8Array;
        readonly dlc: Uint8Array;
        /** First 8 bytes of each frame, zeros behind the last one. */
        readonly data: Uint8Array;
        /** Index of the frame's table in `tables`; 255 unknown, 254 malformed, 253 an error frame. */
        readonly message: Uint8Array;
    };
    /** The tables that have rows. */
    readonly tables: readonly MessageTable[];
    /** Lines that are no frame. */
    readonly errors: readonly { readonly line: number; readonly text: string; readonly reason: string }[];
}
"#;

const OPTIONS: [&str; 3] = ["slave", "monitor", "encoders"];

/// Decodes a log of can-utils (`candump -L`), given as text or bytes.
#[wasm_bindgen(js_name = readLog, unchecked_return_type = "CanLog")]
pub fn read_log(
    #[wasm_bindgen(unchecked_param_type = "string | Uint8Array")] text: &JsValue,
    #[wasm_bindgen(unchecked_optional_param_type = "LogOptions")] options: &JsValue,
) -> Result<Object, JsValue> {
    let options = Options::new("readLog", options, &OPTIONS)?;
    let Addresses { drive, master } = Addresses::FACTORY;
    let ends = Ends { slave: end(&options, "slave", drive)?, monitor: end(&options, "monitor", master)? };
    let bytes = match (text.as_string(), text.dyn_ref::<Uint8Array>()) {
        (Some(text), _) => text.into_bytes(),
        (None, Some(bytes)) => bytes.to_vec(),
        _ => return Err(type_error("readLog: the log must be text or a Uint8Array")),
    };
    let mut log = CanLog::new(Config { ends, encoders: encoders(&options)? });
    log.read_candump(&bytes, 1);
    Ok(object(&log))
}

fn end(options: &Options, name: &str, factory: u8) -> Result<Option<u8>, JsValue> {
    if options.value(name)?.is_some_and(|value| value.is_null()) {
        return Ok(None);
    }
    Ok(Some(options.whole(name, 0.0, 255.0)?.map_or(factory, |address| address as u8)))
}

fn encoders(options: &Options) -> Result<u128, JsValue> {
    let Some(given) = options.value("encoders")? else { return Ok(0) };
    let refused = || type_error("readLog: encoders must be an array of node-ids");
    let nodes = given.dyn_into::<Array>().map_err(|_| refused())?;
    nodes.iter().try_fold(0, |bits, node| {
        let node = whole("encoders", node.as_f64().ok_or_else(refused)?, 1.0, 127.0)?;
        Ok(bits | 1 << node as u32)
    })
}

fn object(log: &CanLog) -> Object {
    // Tables without rows are left out, so the indices of the others change.
    let mut places = [Kind::Unknown as u8; 256];
    for kind in [Kind::Malformed, Kind::Error] {
        places[kind as usize] = kind as u8;
    }
    let tables = Array::new();
    for (place, shown) in log.tables.iter().enumerate().filter(|(_, table)| !table.time.is_empty()) {
        places[place] = tables.length() as u8;
        tables.push(&table(shown));
    }
    let shaped = Object::new();
    set(&shaped, "lines", log.lines as f64);
    set(&shaped, "frames", frames(&log.frames, &places));
    set(&shaped, "tables", tables);
    set(&shaped, "errors", log.errors.iter().map(error).collect::<Array>());
    shaped
}

fn frames(frames: &Frames, places: &[u8; 256]) -> Object {
    let message: Vec<u8> = frames.message.iter().map(|place| places[usize::from(*place)]).collect();
    let known = flag::EXTENDED | flag::REMOTE | flag::ERROR | flag::FD | flag::RECEIVED;
    let flags: Vec<u8> = frames.flags.iter().map(|flags| flags & known).collect();
    let shaped = Object::new();
    set(&shaped, "time", Float64Array::from(frames.time.as_slice()));
    set(&shaped, "id", Uint32Array::from(frames.id.as_slice()));
    set(&shaped, "flags", Uint8Array::from(flags.as_slice()));
    set(&shaped, "dlc", Uint8Array::from(frames.dlc.as_slice()));
    set(&shaped, "data", Uint8Array::from(frames.data.as_flattened()));
    set(&shaped, "message", Uint8Array::from(message.as_slice()));
    shaped
}

fn table(table: &Table) -> Object {
    let (columns, units, names) = (Object::new(), Object::new(), Object::new());
    for (signal, values) in table.signals.iter().zip(&table.columns) {
        set(&columns, signal.name, Float64Array::from(numbers(values).as_slice()));
        set(&units, signal.name, signal.unit);
        if !signal.names.is_empty() {
            let named = Object::new();
            for (number, name) in &signal.names {
                // Keys are numbers, which `set` does not accept. Setting a new property cannot fail.
                let _ = Reflect::set_u32(&named, u32::from(*number), &(*name).into());
            }
            set(&names, signal.name, named);
        }
    }
    let shaped = Object::new();
    set(&shaped, "name", table.name.as_str());
    set(&shaped, "fromDevice", table.from_device);
    set(&shaped, "time", Float64Array::from(table.time.as_slice()));
    set(&shaped, "columns", columns);
    set(&shaped, "units", units);
    set(&shaped, "names", names);
    shaped
}

/// Converts values to floats, exactly: none has more than 48 bits.
fn numbers(values: &Values) -> Vec<f64> {
    match values {
        Values::Quantity(values) => values.clone(),
        Values::Number(values) => values.iter().map(|value| *value as f64).collect(),
        Values::Code(values) => values.iter().map(|value| f64::from(*value)).collect(),
        Values::Flag(values) => values.iter().map(|value| f64::from(u8::from(*value))).collect(),
        Values::Faults(values) => values.iter().map(|value| f64::from(*value)).collect(),
    }
}

fn error(error: &LineError) -> Object {
    let shaped = Object::new();
    set(&shaped, "line", error.line as f64);
    set(&shaped, "text", error.text.as_str());
    set(&shaped, "reason", error.reason);
    shaped
}
