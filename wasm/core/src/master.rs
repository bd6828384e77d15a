//! Master of a drive: frames and times in, frames out.

use crate::description::{self, Tables};
use crate::dictionary::choice;
use crate::messages::{faults, status};
use crate::requests;
use js_sys::{Array, Object, Uint8Array};
use narx_core::bus::Frame;
use narx_core::bus::narmotion::{Addresses, MotorMode, StatusWord};
use narx_core::master::{Config, Download, Master as Core, Received, SpeedLimits};
use narx_wasm_values::error::{range_error, shown, whole};
use narx_wasm_values::frame;
use narx_wasm_values::options::{Options, set};
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** Configuration of a master. */
export interface MasterOptions {
    /** Address of the drive, 0 to 255; default 170. */
    slave?: number;
    /** Address of the master, 0 to 255; default 85. */
    monitor?: number;
    /** Period of the set-points, 0.001 to 10 s; default 0.05. */
    setpointPeriod?: number;
    /** Listens only and transmits nothing; default false. */
    silent?: boolean;
    /** Reads every parameter in the background when the first frame of the drive is received, and after an action that
     * changes many of them; default true. */
    readParameters?: boolean;
    /** Longest time until an answer, 0.001 to 10 s; default 0.1. */
    timeout?: number;
}

/** A received measurement. */
export interface Measurement {
    readonly name: MeasurementName;
    readonly unit: string;
    readonly value: number;
    /** Time of reception, s. */
    readonly time: number;
}

/** The last CRITICAL_FAULT. */
export interface CriticalFault {
    readonly faults: FaultName[];
    /** Extended fault code. */
    readonly code: number;
    /** Meaning of the code; absent for a code that this version does not know. */
    readonly meaning?: string;
}

/** BUILD_INFO. */
export interface BuildInfo {
    readonly number: number;
    /** True if built from sources that were not committed. */
    readonly modified: boolean;
    /** Date of the build, YYYYMMDD. */
    readonly date: number;
}

/** Length and check value of a drive's description. */
export interface DescriptionInfo {
    readonly words: number;
    /** CRC-32 of the words; 0 if the drive does not report it. */
    readonly check: number;
}

/** Set-points that the drive accepts unchanged, in the control mode that its enables select: magnitudes, rpm.
 * It clamps all others. */
export interface SpeedLimits {
    readonly min: number;
    readonly max: number;
    /** True if the drive runs at one speed, whatever is requested: open loop at parameter 88. */
    readonly fixed: boolean;
}

/** DEVICE_INFO. */
export interface DeviceInfo {
    /** Release of the board. */
    readonly hardware: number;
    /** Release of the firmware, major.minor. */
    readonly software: string;
    /** Serial number. */
    readonly deviceNumber: number;
    readonly address: number;
}

/** Words of a download. */
export interface Chunk {
    /** Place of the first word in the download, words. */
    readonly offset: number;
    /** Bytes of the words, high byte first. */
    readonly bytes: Uint8Array;
}

/** Progress of a download, words. */
export interface Progress {
    readonly received: number;
    readonly total: number;
}
"#;

const OPTIONS: [&str; 6] = ["slave", "monitor", "setpointPeriod", "silent", "readParameters", "timeout"];
/// Largest set-point of MOTOR_CMD.
pub(crate) const RPM_MAX: f64 = u16::MAX as f64;

/// The master of a drive, at the other end of its bus. It has no clock and no bus of its own. Times are
/// seconds from any beginning and never decrease. Pass it every frame that arrives, and send the frames of
/// `poll`, at the latest at `nextPoll`. Calls that wait for answers are in `narx/drive`.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Master {
    pub(crate) core: Core,
    /// Latest time that was passed in, microseconds.
    pub(crate) now: u64,
    /// Image of the update.
    pub(crate) image: Vec<u8>,
    /// Tables from the drive's description; `None`: those of this package are used.
    pub(crate) tables: Option<Tables>,
    /// Numbers and raw values, as last received, of parameters that this package's tables do not have.
    pub(crate) others: Vec<(u16, i32)>,
}

#[wasm_bindgen]
impl Master {
    /// Makes a master that has received nothing yet. Throws for an invalid option.
    #[wasm_bindgen(constructor)]
    pub fn new(
        #[wasm_bindgen(unchecked_optional_param_type = "MasterOptions")] options: &JsValue,
    ) -> Result<Master, JsValue> {
        let options = Options::new("Master", options, &OPTIONS)?;
        let factory = Config::default();
        let address = |name, factory| {
            Ok::<u8, JsValue>(options.whole(name, 0.0, 255.0)?.map_or(factory, |address| address as u8))
        };
        let time = |name, factory| match options.number(name)? {
            Some(seconds) if (0.001..=10.0).contains(&seconds) => Ok(microseconds(seconds)),
            None => Ok(factory),
            Some(seconds) => Err(range_error(&format!(
                "Master: {name} {} s: must be 0.001 to 10 s",
                shown(&seconds.into())
            ))),
        };
        let Addresses { drive, master } = factory.addresses;
        let config = Config {
            addresses: Addresses { drive: address("slave", drive)?, master: address("monitor", master)? },
            setpoint_period: time("setpointPeriod", factory.setpoint_period)?,
            timeout: time("timeout", factory.timeout)?,
            silent: options.flag("silent")?.unwrap_or(factory.silent),
            read_parameters: options.flag("readParameters")?.unwrap_or(factory.read_parameters),
            ..factory
        };
        let core = Core::new(config);
        Ok(Self { core, now: 0, image: Vec::new(), tables: None, others: Vec::new() })
    }

    /// Takes a frame that arrived at `now`, s. Only messages of its drive to this master are used.
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

    /// Returns the next frame that is due at `now`, s.
    #[wasm_bindgen(js_name = pollFrame, unchecked_return_type = "Frame | undefined")]
    pub fn poll_frame(&mut self, now: f64) -> JsValue {
        self.tell(now);
        let due = self.next_frame();
        due.map_or(JsValue::UNDEFINED, |due| frame::object(&due).into())
    }

    /// Returns every frame that is due at `now`, s.
    #[wasm_bindgen(unchecked_return_type = "Frame[]")]
    pub fn poll(&mut self, now: f64) -> Array {
        self.tell(now);
        std::iter::from_fn(|| self.next_frame()).map(|due| frame::object(&due)).collect()
    }

    /// Returns the latest time of the next poll, s, if no frame arrives and nothing is requested until then;
    /// infinity if there is none.
    #[wasm_bindgen(js_name = nextPoll)]
    pub fn next_poll(&mut self, now: f64) -> f64 {
        self.tell(now);
        match self.core.next_poll(self.now) {
            u64::MAX => f64::INFINITY,
            due => seconds(due),
        }
    }

    /// Requests a start at a speed, mechanical rpm, negative in reverse. A drive accepts a start only after
    /// Standby: call `stop` first.
    pub fn start(&mut self, rpm: f64) -> Result<(), JsValue> {
        self.core.start(whole("start", rpm, -RPM_MAX, RPM_MAX)? as i32);
        Ok(())
    }

    /// Requests another speed in the same direction, rpm.
    #[wasm_bindgen(js_name = setSpeed)]
    pub fn set_speed(&mut self, rpm: f64) -> Result<(), JsValue> {
        self.core.set_speed(whole("setSpeed", rpm, 0.0, RPM_MAX)? as u16);
        Ok(())
    }

    /// Set-points that the drive accepts unchanged; `undefined` before the needed ones of `speedParameters`
    /// were received.
    #[wasm_bindgen(getter, js_name = speedLimits, unchecked_return_type = "SpeedLimits | undefined")]
    pub fn speed_limits(&self) -> JsValue {
        let Some(SpeedLimits { min, max }) = self.limits() else { return JsValue::UNDEFINED };
        let shaped = Object::new();
        set(&shaped, "min", min.rpm);
        set(&shaped, "max", max.rpm);
        set(&shaped, "fixed", min == max);
        shaped.into()
    }

    /// Throws a `RangeError` for a set-point, rpm, negative in reverse, that the drive would clamp. The error
    /// names the limit's parameter and the range. Before the drive's limits were received, only the range of
    /// MOTOR_CMD is checked.
    #[wasm_bindgen(js_name = checkSpeed)]
    pub fn check_speed(&self, rpm: f64) -> Result<(), JsValue> {
        let rpm = whole("speed", rpm, -RPM_MAX, RPM_MAX)? as i32;
        self.limits().unwrap_or(SpeedLimits::WIRE).check(rpm).map_err(|refused| range_error(&refused))
    }

    /// True if the last request was Drive or Reverse.
    #[wasm_bindgen(getter, js_name = asksToTurn)]
    pub fn asks_to_turn(&self) -> bool {
        matches!(self.core.requested(), Some(MotorMode::Drive | MotorMode::Reverse))
    }

    /// Requests Standby, which also acknowledges a fault.
    pub fn stop(&mut self) {
        self.core.stop();
    }

    /// Requests a shutdown: fault bit 28.
    #[wasm_bindgen(js_name = shutDown)]
    pub fn shut_down(&mut self) {
        self.core.shut_down();
    }

    /// Magnitude of the set-point, rpm.
    #[wasm_bindgen(getter)]
    pub fn setpoint(&self) -> u16 {
        self.core.setpoint()
    }

    /// Time between two set-points, s.
    #[wasm_bindgen(getter, js_name = setpointPeriod)]
    pub fn setpoint_period(&self) -> f64 {
        seconds(self.core.config().setpoint_period)
    }

    /// True for a master that transmits nothing.
    #[wasm_bindgen(getter)]
    pub fn silent(&self) -> bool {
        self.core.config().silent
    }

    /// True if a frame of the drive was received within the last 0.5 s, or within three of its broadcast
    /// periods if that is longer.
    #[wasm_bindgen(getter)]
    pub fn connected(&self) -> bool {
        self.core.is_connected(self.now)
    }

    /// Time at which any message of the drive was last received, s.
    #[wasm_bindgen(getter, js_name = lastReceived)]
    pub fn last_received(&self) -> Option<f64> {
        self.core.report().last.map(seconds)
    }

    /// State of the drive, 0 to 7; `undefined` while unknown.
    #[wasm_bindgen(getter)]
    pub fn state(&self) -> Option<u8> {
        self.core.state().map(|state| state as u8)
    }

    /// Name of the state in the specification.
    #[wasm_bindgen(getter, js_name = stateName, unchecked_return_type = "StateName | undefined")]
    pub fn state_name(&self) -> Option<String> {
        self.core.state().map(|state| state.name().to_owned())
    }

    /// Names of the set bits of FAULT_WORD; `undefined` before the first.
    #[wasm_bindgen(getter, unchecked_return_type = "FaultName[] | undefined")]
    pub fn faults(&self) -> JsValue {
        let received = self.core.report().faults;
        received.map_or(JsValue::UNDEFINED, |received| faults(received.value).into())
    }

    /// The last CRITICAL_FAULT. `faults` shows whether it still holds.
    #[wasm_bindgen(getter, unchecked_return_type = "CriticalFault | undefined")]
    pub fn critical(&self) -> JsValue {
        let Some(Received { value, .. }) = self.core.report().critical else { return JsValue::UNDEFINED };
        let shaped = Object::new();
        set(&shaped, "faults", faults(value.faults));
        set(&shaped, "code", value.code);
        if let Some(cause) = value.cause() {
            set(&shaped, "meaning", cause.meaning);
        }
        shaped.into()
    }

    /// The last STATUS_WORD (Table 8).
    #[wasm_bindgen(getter, unchecked_return_type = "DriveValues[\"STATUS_WORD\"] | undefined")]
    pub fn status(&self) -> JsValue {
        let received = self.core.report().status;
        received.map_or(JsValue::UNDEFINED, |received| status(StatusWord::encode(received.value)))
    }

    /// Set-point that the drive has accepted, rpm.
    #[wasm_bindgen(getter, js_name = acceptedSpeed)]
    pub fn accepted_speed(&self) -> Option<u16> {
        self.core.report().accepted_speed.map(|received| received.value)
    }

    /// The last BUILD_INFO.
    #[wasm_bindgen(getter, unchecked_return_type = "BuildInfo | undefined")]
    pub fn build(&self) -> JsValue {
        let Some(Received { value, .. }) = self.core.report().build else { return JsValue::UNDEFINED };
        let shaped = Object::new();
        set(&shaped, "number", value.number);
        set(&shaped, "modified", value.modified);
        set(&shaped, "date", value.date);
        shaped.into()
    }

    /// The last DEVICE_INFO.
    #[wasm_bindgen(getter, unchecked_return_type = "DeviceInfo | undefined")]
    pub fn device(&self) -> JsValue {
        let Some(Received { value, .. }) = self.core.report().device else { return JsValue::UNDEFINED };
        let shaped = Object::new();
        set(&shaped, "hardware", value.hardware);
        set(&shaped, "software", format!("{}.{}", value.software >> 8, value.software & 0xFF));
        set(&shaped, "deviceNumber", value.device_number);
        set(&shaped, "address", value.address);
        shaped.into()
    }

    /// Returns the measurements that were received, in the order of Figure 14.
    #[wasm_bindgen(unchecked_return_type = "Measurement[]")]
    pub fn measurements(&self) -> Array {
        description::measurements(self.tables.as_ref(), self.core.measurements())
    }

    /// Mechanical speed from the source that the control mode uses, rpm.
    #[wasm_bindgen(getter)]
    pub fn speed(&self) -> Option<i16> {
        self.core.speed().map(|received| received.value)
    }

    /// Returns the value of a parameter as last received, in its unit; `undefined` before.
    pub fn parameter(
        &self,
        #[wasm_bindgen(unchecked_param_type = "ParameterName | number")] key: &JsValue,
    ) -> Result<Option<f64>, JsValue> {
        let number = description::number(self.tables.as_ref(), key)?;
        let known = self.core.parameters().get(number).map(|received| received.value);
        let raw = known.or_else(|| Some(self.others.iter().find(|(other, _)| *other == number)?.1));
        Ok(raw.map(|raw| self.value(number, raw)))
    }

    /// Replaces the tables of the drive by those of its description, the bytes of a download; without `text`
    /// by those of this package. `check` is the CRC-32 that the drive reports for it. Throws for a text that
    /// cannot be read, and then keeps the previous tables.
    pub fn describe(&mut self, text: Option<Vec<u8>>, check: Option<u32>) -> Result<(), JsValue> {
        self.tables = text.map(|text| Tables::read(&text, check.unwrap_or(0))).transpose()?;
        Ok(())
    }

    /// Length and check value of the drive's description, as last received.
    #[wasm_bindgen(getter, js_name = descriptionInfo, unchecked_return_type = "DescriptionInfo | undefined")]
    pub fn description_info(&self) -> JsValue {
        let Some(Received { value, .. }) = self.core.report().description else { return JsValue::UNDEFINED };
        let shaped = Object::new();
        set(&shaped, "words", value.words);
        set(&shaped, "check", value.check);
        shaped.into()
    }

    /// Returns every parameter of the drive in the order of its description.
    #[wasm_bindgen(unchecked_return_type = "Parameter[]")]
    pub fn parameters(&self) -> Array {
        description::parameters(self.tables.as_ref())
    }

    /// Returns the signals of the drive's scope in the order of its description.
    #[wasm_bindgen(js_name = scopeSignals, unchecked_return_type = "ScopeSignal[]")]
    pub fn scope_signals(&self) -> Array {
        description::scope_signals(self.tables.as_ref())
    }

    /// Returns the signals of the drive's measurements in the order of its description.
    #[wasm_bindgen(js_name = measurementSignals, unchecked_return_type = "MeasurementSignal[]")]
    pub fn measurement_signals(&self) -> Array {
        description::measurement_signals(self.tables.as_ref())
    }

    /// Reads every parameter anew in the background.
    #[wasm_bindgen(js_name = readParameters)]
    pub fn read_parameters(&mut self) {
        self.core.read_parameters();
    }

    /// Number of parameters that are still to be read in the background.
    #[wasm_bindgen(getter, js_name = parametersToRead)]
    pub fn parameters_to_read(&self) -> usize {
        self.core.parameters_to_read()
    }

    /// Begins a download: "description", "scope" with `count` words, "log" with `count` records from `first`
    /// on. Throws for a silent master, and during another download.
    pub fn download(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "\"description\" | \"scope\" | \"log\"")] what: &JsValue,
        count: Option<u32>,
        first: Option<u32>,
    ) -> Result<(), JsValue> {
        let count = count.unwrap_or(0);
        let choices = [
            ("description", Download::Description),
            ("scope", Download::Scope { words: count }),
            ("log", Download::Log { first: first.unwrap_or(0), records: count }),
        ];
        let what = choice("download", what, &choices)?;
        self.core.download(what).map_err(|refused| requests::thrown(requests::REFUSED, &refused))
    }

    /// Returns the words that have come since the previous call. Words may come more than once, each time the
    /// same.
    #[wasm_bindgen(js_name = pollChunks, unchecked_return_type = "Chunk[]")]
    pub fn poll_chunks(&mut self) -> Array {
        let shape = |chunk: narx_core::master::Chunk| {
            let bytes: Vec<u8> = chunk.bytes().collect();
            let shaped = Object::new();
            set(&shaped, "offset", chunk.offset);
            set(&shaped, "bytes", Uint8Array::from(bytes.as_slice()));
            shaped
        };
        std::iter::from_fn(|| self.core.poll_chunk()).map(shape).collect()
    }

    /// Progress of the download; `undefined` before its length is known, and without one.
    #[wasm_bindgen(getter, js_name = downloadProgress, unchecked_return_type = "Progress | undefined")]
    pub fn download_progress(&self) -> JsValue {
        let Some(progress) = self.core.download_progress() else { return JsValue::UNDEFINED };
        let shaped = Object::new();
        set(&shaped, "received", progress.received);
        set(&shaped, "total", progress.total);
        shaped.into()
    }

    /// Returns the length of the download in words, once all its chunks were taken. Throws a `MasterError`
    /// for one that failed.
    #[wasm_bindgen(js_name = pollDownload)]
    pub fn poll_download(&mut self) -> Result<Option<u32>, JsValue> {
        self.core.poll_download().transpose().map_err(requests::download_error)
    }

    /// Aborts the download.
    #[wasm_bindgen(js_name = abortDownload)]
    pub fn abort_download(&mut self) {
        self.core.abort_download();
    }
}

impl Master {
    /// Converts a parameter's raw value to its unit, with the drive's own scale.
    pub(crate) fn value(&self, number: u16, raw: i32) -> f64 {
        let shape = description::shape(self.tables.as_ref(), number);
        shape.map_or(0.0, |shape| shape.scale.to_unit(shape.kind.widen(raw)))
    }

    fn limits(&self) -> Option<SpeedLimits> {
        SpeedLimits::of(|number| {
            let received = self.core.parameters().get(number)?;
            Some(self.value(number, received.value).round() as i32)
        })
    }

    /// Advances the time to `now`; it never goes back.
    fn tell(&mut self, now: f64) {
        self.now = self.now.max(microseconds(now));
    }

    fn next_frame(&mut self) -> Option<Frame> {
        let Self { core, now, image, .. } = self;
        core.poll_frame(*now).or_else(|| core.poll_update_frame(*now, image))
    }
}

/// Returns the numbers of the parameters that determine `speedLimits`.
#[wasm_bindgen(js_name = speedParameters)]
pub fn speed_parameters() -> Vec<u16> {
    SpeedLimits::PARAMETERS.to_vec()
}

pub(crate) fn microseconds(seconds: f64) -> u64 {
    (seconds * 1e6).round() as u64
}

pub(crate) fn seconds(microseconds: u64) -> f64 {
    microseconds as f64 / 1e6
}
