//! Lines of an slcan adapter, for Web Serial.

use js_sys::{Array, Object};
use narx_core::bus::slcan::{BITRATES, Command, Lines, NO, decode_frame, encode_frame};
use narx_wasm_values::error::{range_error, whole};
use narx_wasm_values::frame;
use wasm_bindgen::prelude::*;

/// Decoder of the bytes from an slcan adapter. Lines that are no frames are counted or ignored.
#[wasm_bindgen]
#[derive(Debug, Default)]
pub struct SlcanLines {
    lines: Lines,
    refusals: u32,
}

#[wasm_bindgen]
impl SlcanLines {
    /// Makes a decoder before the first byte.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes bytes as they arrived, and returns the frames that they complete.
    #[wasm_bindgen(js_name = handleBytes, unchecked_return_type = "Frame[]")]
    pub fn handle_bytes(&mut self, bytes: &[u8]) -> Array {
        let mut take = |byte: &u8| -> Option<Object> {
            // A refusal has no line end.
            if *byte == NO {
                self.refusals = self.refusals.saturating_add(1);
                return None;
            }
            let line = self.lines.push(*byte)??;
            decode_frame(&line).map(|(frame, _)| frame::object(&frame))
        };
        bytes.iter().filter_map(&mut take).collect()
    }

    /// Number of commands that the adapter has refused.
    #[wasm_bindgen(getter)]
    pub fn refusals(&self) -> u32 {
        self.refusals
    }
}

/// Encodes a frame for an adapter.
#[wasm_bindgen(js_name = encodeSlcan)]
pub fn encode_slcan(
    #[wasm_bindgen(unchecked_param_type = "Frame")] frame: &JsValue,
) -> Result<Vec<u8>, JsValue> {
    Ok(encode_frame(&frame::parse(frame)?, None).to_vec())
}

/// Returns the commands that open an adapter at this bit rate, bit/s (default 500 000, that of the drive).
/// The adapter is closed first, whatever its state.
#[wasm_bindgen(js_name = openSlcan)]
pub fn open_slcan(bitrate: Option<f64>, listen: Option<bool>) -> Result<Vec<u8>, JsValue> {
    let bitrate = whole("bitrate", bitrate.unwrap_or(500_000.0), 0.0, u32::MAX.into())? as u32;
    let index = BITRATES.iter().position(|known| *known == bitrate).ok_or_else(|| {
        range_error(&format!("bitrate {bitrate}: an slcan adapter has 10000 to 1000000 bit/s in nine steps"))
    })?;
    let open = if listen.unwrap_or(false) { Command::ListenOnly } else { Command::Open };
    let commands = [Command::Nothing, Command::Close, Command::Bitrate(index as u8), open];
    Ok(commands.iter().flat_map(Command::encode).collect())
}

/// Returns the command that closes an adapter.
#[wasm_bindgen(js_name = closeSlcan)]
pub fn close_slcan() -> Vec<u8> {
    Command::Close.encode().to_vec()
}
