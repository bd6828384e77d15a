//! Master of a TX-Driver: frames and times in, frames out.

use crate::dictionary::choice;
use crate::master::{microseconds, seconds};
use crate::messages::float;
use crate::requests::{NO_ANSWER, REFUSED, thrown};
use js_sys::{Array, Object};
use narx_core::bus::eddycan::{Channels, ErrorCode, Layout, NmtCommand, NmtState, NodeId, PdoKind};
use narx_core::eddycan::{Entry, OBJECTS, Object as Row};
use narx_core::master::NotTaken;
use narx_core::master::eddycan::{Config, Request, RequestError, TxMaster as Core};
use narx_wasm_values::error::{range_error, shown};
use narx_wasm_values::frame;
use narx_wasm_values::options::{Options, set};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Configuration of a TX-Driver's master. */
export interface TxMasterOptions {
    /** Node-id, 1 to 127. */
    nodeId: number;
    /** Number of sensors; default 1. */
    channels?: 1 | 2;
    /** Longest time until an answer, 0.003 to 10 s; default 0.1. */
    timeout?: number;
}

/** The last positions of a TX-Driver. */
export interface Reading {
    /** Positions from the start of the measuring range, mm, one for each channel. */
    readonly positions: readonly number[];
    /** Counts; of a linear encoder with their sign once 2005h was read. Absent if PDOs do not carry the
     * encoder. */
    readonly encoder?: number;
    /** Position of a linear encoder, mm: counts times resolution. Absent before 2005h and 2009h were read,
     * and for a rotary one. */
    readonly encoderPosition?: number;
    readonly trigger: "timer" | "sync" | "remote";
    /** Time of reception, s. */
    readonly time: number;
}

/** An entry of the object dictionary (eddyCAN specification, Table 4). Limits and factory value are in its
 * unit. */
export interface TxObject {
    readonly index: number;
    readonly subindex: number;
    readonly name: string;
    readonly unit: string;
    /** Value of a raw 1. */
    readonly scale: number;
    readonly min: number;
    readonly max: number;
    readonly factory: number;
    readonly access: string;
    readonly acts: "at once" | "after a restart";
    readonly description: string;
}

/** The raw value that was read or written, or the error; `abort` is the code of a node's refusal. */
export type TxAnswer =
    | { readonly value: number; readonly error?: undefined }
    | { readonly error: MasterError; readonly abort?: number };
"#;

/// The master of a TX-Driver, at the other end of its bus. Times are seconds from any beginning and never
/// decrease.
#[wasm_bindgen]
#[derive(Debug)]
pub struct TxMaster {
    core: Core,
    now: u64,
}

#[wasm_bindgen]
impl TxMaster {
    /// Makes a master that sends nothing until it gets a command or a request.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(unchecked_param_type = "TxMasterOptions")] options: &JsValue,
    ) -> Result<TxMaster, JsValue> {
        let options = Options::new("TxMaster", options, &["nodeId", "channels", "timeout"])?;
        options.required("nodeId")?;
        let node = options.whole("nodeId", 1.0, 127.0)?.and_then(|node| NodeId::new(node as u8));
        let node = node.ok_or_else(|| range_error(&"TxMaster: nodeId must be 1 to 127"))?;
        let channels = match options.whole("channels", 1.0, 2.0)? {
            Some(2.0) => Channels::Dual,
            _ => Channels::Single,
        };
        let mut config = Config::new(node, Layout { channels, encoder: false });
        if let Some(timeout) = options.number("timeout")? {
            if !(0.003..=10.0).contains(&timeout) {
                let timeout = shown(&timeout.into());
                return Err(range_error(&format!("TxMaster: timeout {timeout} s: must be 0.003 to 10 s")));
            }
            config.timeout = microseconds(timeout);
        }
        Ok(Self { core: Core::new(config), now: 0 })
    }

    /// Takes a frame that arrived at `now`, s. Only messages of its node are used.
    #[wasm_bindgen(js_name = handleFrame)]
    pub fn handle_frame(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "Frame")] frame: &JsValue,
        now: f64,
    ) -> Result<(), JsValue> {
        let frame = frame::parse(frame)?;
        self.tell(now);
        self.core.handle_frame(&frame, self.now);
        Ok(())
    }

    /// Returns every frame that is due at `now`, s.
    #[wasm_bindgen(unchecked_return_type = "Frame[]")]
    pub fn poll(&mut self, now: f64) -> Array {
        self.tell(now);
        let now = self.now;
        std::iter::from_fn(|| self.core.poll_frame(now)).map(|due| frame::object(&due)).collect()
    }

    /// Returns the latest time of the next poll, s; infinity if there is none.
    #[wasm_bindgen(js_name = nextPoll)]
    pub fn next_poll(&mut self, now: f64) -> f64 {
        self.tell(now);
        match self.core.next_poll(self.now) {
            u64::MAX => f64::INFINITY,
            due => seconds(due),
        }
    }

    /// Commands the node (NMT).
    pub fn command(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "\"start\" | \"stop\" | \"pre-operational\" | \"reset\"")]
        command: &JsValue,
    ) -> Result<(), JsValue> {
        let commands = [
            ("start", NmtCommand::Start),
            ("stop", NmtCommand::Stop),
            ("pre-operational", NmtCommand::PreOperational),
            ("reset", NmtCommand::Reset),
        ];
        let command = choice("command", command, &commands)?;
        self.core.command(command).map_err(not_taken)
    }

    /// Sends a SYNC: every node samples and sends PDO2.
    pub fn sync(&mut self) -> Result<(), JsValue> {
        self.core.sync().map_err(not_taken)
    }

    /// Requests PDO3.
    #[wasm_bindgen(js_name = askPositions)]
    pub fn ask_positions(&mut self) -> Result<(), JsValue> {
        self.core.ask_positions().map_err(not_taken)
    }

    /// Queues a request that reads an entry, or writes a raw value to it.
    pub fn request(&mut self, index: u16, subindex: u8, value: Option<u32>) -> Result<(), JsValue> {
        let entry = Entry::find(index, subindex).map_err(|refused| range_error(&refused))?;
        let request = value.map_or(Request::Read(entry), |value| Request::Write(entry, value));
        self.core.request(request).map_err(not_taken)
    }

    /// Returns the next answer; `undefined` before it has come.
    #[wasm_bindgen(js_name = pollAnswer, unchecked_return_type = "TxAnswer | undefined")]
    pub fn poll_answer(&mut self) -> JsValue {
        let Some(answer) = self.core.poll_answer() else { return JsValue::UNDEFINED };
        let (Request::Read(entry) | Request::Write(entry, _)) = answer.request;
        let Row { index, name, .. } = entry.object();
        let node = self.core.config().node.raw();
        let shaped = Object::new();
        match answer.result {
            Ok(value) => set(&shaped, "value", value),
            Err(error) => {
                let (kind, code) = match error {
                    RequestError::NoAnswer => (NO_ANSWER, None),
                    RequestError::Refused(code) => (REFUSED, Some(code as u32)),
                    RequestError::RefusedOtherwise { code } => (REFUSED, Some(code)),
                };
                let message = format!("node {node}, {index:04X}h \"{name}\": {error}");
                set(&shaped, "error", thrown(kind, &message));
                if let Some(code) = code {
                    set(&shaped, "abort", code);
                }
            }
        }
        shaped.into()
    }

    /// The last positions since the node booted, if there are any.
    #[wasm_bindgen(getter, unchecked_return_type = "Reading | undefined")]
    pub fn reading(&self) -> JsValue {
        let Some((reading, kind, time)) = self.core.reading() else { return JsValue::UNDEFINED };
        let layout = self.core.config().layout;
        // Positions are in 2^-27 mm; the division is exact.
        let positions = reading.positions.map(|position| f64::from(position.raw()) / f64::from(1 << 27));
        let count = if layout.channels == Channels::Dual { 2 } else { 1 };
        let shaped = Object::new();
        let positions = positions.into_iter().take(count).map(JsValue::from).collect::<Array>();
        set(&shaped, "positions", positions);
        if layout.encoder {
            let encoder = self.core.report().encoder;
            set(&shaped, "encoder", encoder.counts(&reading));
            if let Some(position) = encoder.position(&reading) {
                set(&shaped, "encoderPosition", float(position));
            }
        }
        let trigger = match kind {
            PdoKind::Timer => "timer",
            PdoKind::Sync => "sync",
            PdoKind::Remote => "remote",
        };
        set(&shaped, "trigger", trigger);
        set(&shaped, "time", seconds(time));
        shaped.into()
    }

    /// State in the last heartbeat.
    #[wasm_bindgen(
        getter,
        unchecked_return_type = "\"boot-up\" | \"stopped\" | \"operational\" | \"pre-operational\" | undefined"
    )]
    pub fn state(&self) -> Option<String> {
        let name = match self.core.report().state? {
            NmtState::BootUp => "boot-up",
            NmtState::Stopped => "stopped",
            NmtState::Operational => "operational",
            NmtState::PreOperational => "pre-operational",
        };
        Some(name.to_owned())
    }

    /// Returns whether a frame of the node was received within 5 s.
    #[wasm_bindgen(getter)]
    pub fn present(&self) -> bool {
        self.core.is_present(self.now)
    }

    /// Number of boot-up messages.
    #[wasm_bindgen(getter)]
    pub fn boots(&self) -> u32 {
        self.core.report().boots
    }

    /// Number of error messages.
    #[wasm_bindgen(getter)]
    pub fn errors(&self) -> u32 {
        self.core.report().errors
    }

    /// Meaning of the last error message (Table 13).
    #[wasm_bindgen(getter, js_name = lastError)]
    pub fn last_error(&self) -> Option<String> {
        let code = self.core.report().last_error?;
        Some(
            ErrorCode::decode(code)
                .map_or_else(|| format!("code {code:#06x}"), |code| code.meaning().to_owned()),
        )
    }

    /// Number of the node's frames that cannot be decoded: most likely PDOs of another layout.
    #[wasm_bindgen(getter)]
    pub fn malformed(&self) -> u32 {
        self.core.report().malformed
    }
}

impl TxMaster {
    /// Advances the time to `now`; it never goes back.
    fn tell(&mut self, now: f64) {
        self.now = self.now.max(microseconds(now));
    }
}

/// Returns the object dictionary in order.
#[wasm_bindgen(js_name = txObjects, unchecked_return_type = "TxObject[]")]
pub fn tx_objects() -> Array {
    OBJECTS.iter().map(object).collect()
}

fn object(row: &Row) -> Object {
    // The unit is a fraction of the measuring range.
    let (unit, scale) = match row.unit {
        "2^-30" => ("", 1.0 / f64::from(1 << 30)),
        "-" => ("", 1.0),
        unit => (unit, 1.0),
    };
    let shaped = Object::new();
    set(&shaped, "index", row.index);
    set(&shaped, "subindex", row.subindex.unwrap_or(0));
    set(
        &shaped,
        "name",
        row.subindex.map_or(row.name.to_owned(), |channel| format!("{} {channel}", row.name)),
    );
    set(&shaped, "unit", unit);
    set(&shaped, "scale", scale);
    set(&shaped, "min", f64::from(row.min) * scale);
    set(&shaped, "max", f64::from(row.max) * scale);
    set(&shaped, "factory", f64::from(row.default) * scale);
    set(&shaped, "access", row.access.label());
    set(&shaped, "acts", if row.restart { "after a restart" } else { "at once" });
    set(&shaped, "description", row.description);
    shaped
}

fn not_taken(refused: NotTaken) -> JsValue {
    thrown(REFUSED, &refused)
}
