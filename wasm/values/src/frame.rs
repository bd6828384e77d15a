//! CAN frames as plain objects, which can be passed unchanged between a page and its worker.

use crate::error::{range_error, shown};
use crate::options::{Options, set};
use js_sys::{Object, Uint8Array};
use narx_core::bus::{Frame, Id};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** A classic CAN frame. */
export interface Frame {
    /** Identifier, 29 or 11 bits. */
    readonly id: number;
    /** True for an identifier of 29 bits, as all of the drive's have; default true. */
    readonly extended?: boolean;
    /** True for a remote frame; default false. */
    readonly remote?: boolean;
    /** Up to 8 bytes; of a remote frame as many zeros as it requests bytes. */
    readonly data: Uint8Array;
}
"#;

/// Largest identifiers of 29 and of 11 bits.
const EXTENDED_MAX: f64 = 0x1FFF_FFFF as f64;
const STANDARD_MAX: f64 = 0x7FF as f64;

/// Converts an object to a frame. It may have further properties, like a received frame.
pub fn parse(value: &JsValue) -> Result<Frame, JsValue> {
    let names = ["id", "extended", "remote", "data", "time", "sent", "channel"];
    let options = Options::new("frame", value, &names)?;
    let extended = options.flag("extended")?.unwrap_or(true);
    let max = if extended { EXTENDED_MAX } else { STANDARD_MAX };
    options.required("id")?;
    let raw = options.whole("id", 0.0, max)?.unwrap_or_default() as u32;
    let id = if extended { Id::extended(raw) } else { Id::standard(raw as u16) };
    let data = options.value("data")?.and_then(|data| data.dyn_into::<Uint8Array>().ok());
    let data = data.ok_or_else(|| crate::error::type_error("frame: data must be a Uint8Array"))?.to_vec();
    let remote = options.flag("remote")?.unwrap_or(false);
    let frame = id
        .filter(|_| data.len() <= 8)
        .and_then(|id| if remote { Frame::remote(id, data.len() as u8) } else { Frame::data(id, &data) });
    frame.ok_or_else(|| {
        let length = shown(&(data.len() as f64).into());
        range_error(&format!("frame: data of {length} bytes: must be at most 8"))
    })
}

/// Converts a frame to an object.
pub fn object(frame: &Frame) -> Object {
    let zeros = [0; 8];
    let length = usize::from(frame.dlc()).min(zeros.len());
    let data = if frame.is_remote() { zeros.get(..length).unwrap_or_default() } else { frame.payload() };
    let shaped = Object::new();
    set(&shaped, "id", frame.id().raw());
    set(&shaped, "extended", frame.id().is_extended());
    set(&shaped, "remote", frame.is_remote());
    set(&shaped, "data", Uint8Array::from(data));
    shaped
}
