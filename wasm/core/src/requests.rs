//! What a drive is asked for, and its answers.

use crate::dictionary::{choice, row};
use crate::master::Master;
use js_sys::{Error, Object};
use narx_core::bus::narmotion::{DigitalOutputs, ParameterStatus};
use narx_core::dictionary::Dictionary;
use narx_core::master::{Answer, DownloadError, Refusal, Request, RequestError};
use narx_sim::engineering;
use narx_wasm_values::error::{range_error, whole};
use narx_wasm_values::options::{Options, set};
use std::fmt::Display;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** An `Error` of a master by its `name`: nothing answers, the drive (or this master) does not do it now, a parameter cannot have the value, or an image is none for
 * this drive. */
export interface MasterError extends Error {
    readonly name: "NoAnswerError" | "RefusedError" | "ParameterError" | "ImageError";
}

/** The answer to a request: the value that a parameter has now, in its unit (0 for other requests), or why it was not done. */
export type Answer = { readonly value: number; readonly error?: undefined } | { readonly error: MasterError };

/** What a digital line is: an input, or an output of this level. */
export interface Outputs {
    /** `undefined`: an input. */
    dsio1?: boolean;
    dsio2?: boolean;
}
"#;

pub(crate) const NO_ANSWER: &str = "NoAnswerError";
pub(crate) const REFUSED: &str = "RefusedError";
pub(crate) const PARAMETER: &str = "ParameterError";

#[wasm_bindgen]
impl Master {
    /// Asks the drive for something. Answers come in the order of the requests. Throws a `MasterError` for a silent master, and while eight answers were not
    /// taken.
    pub fn request(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "RequestName")] what: &JsValue,
    ) -> Result<(), JsValue> {
        let request = choice("request", what, &Request::NAMED)?;
        self.take(request)
    }

    /// Asks for a parameter's value.
    pub fn read(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ParameterName | number")] key: &JsValue,
    ) -> Result<(), JsValue> {
        self.take(Request::Read { number: row(key)?.number })
    }

    /// Asks the drive to give a parameter a value, in its unit, to the nearest step of its scale. Throws a `RangeError` for one that it cannot have.
    pub fn write(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ParameterName | number")] key: &JsValue,
        value: f64,
    ) -> Result<(), JsValue> {
        let number = row(key)?.number;
        let raw = engineering::raw(number, value).map_err(|refused| range_error(&refused))?;
        // A value of any kind has 32 bits.
        self.take(Request::Write { number, raw: raw as i32 })
    }

    /// Asks for factory values of everything but what is the board's own. `serial`: parameter 1 of the board that is meant.
    #[wasm_bindgen(js_name = restoreFactory)]
    pub fn restore_factory(&mut self, serial: f64) -> Result<(), JsValue> {
        let serial = whole("serial", serial, 0.0, u16::MAX.into())? as u16;
        self.take(Request::RestoreFactory { serial })
    }

    /// Asks for the digital lines to be inputs, or outputs of a level.
    #[wasm_bindgen(js_name = setOutputs)]
    pub fn set_outputs(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "Outputs")] outputs: &JsValue,
    ) -> Result<(), JsValue> {
        let outputs = Options::new("setOutputs", outputs, &["dsio1", "dsio2"])?;
        let [one, two] = [outputs.flag("dsio1")?, outputs.flag("dsio2")?];
        self.take(Request::DigitalOutputs(DigitalOutputs {
            enable1: one.is_some(),
            value1: one.unwrap_or(false),
            enable2: two.is_some(),
            value2: two.unwrap_or(false),
        }))
    }

    /// The next answer; `undefined` before it is there.
    #[wasm_bindgen(js_name = pollAnswer, unchecked_return_type = "Answer | undefined")]
    pub fn poll_answer(&mut self) -> JsValue {
        let Some(Answer { request, result }) = self.core.poll_answer() else { return JsValue::UNDEFINED };
        let shaped = Object::new();
        match result {
            Ok(raw) => set(&shaped, "value", value(request, raw)),
            Err(error) => set(&shaped, "error", request_error(request, error)),
        }
        shaped.into()
    }
}

impl Master {
    fn take(&mut self, request: Request) -> Result<(), JsValue> {
        self.core.request(request).map_err(|refused| thrown(REFUSED, &refused))
    }
}

fn value(request: Request, raw: i32) -> f64 {
    let number = match request {
        Request::Read { number } | Request::Write { number, .. } => Some(number),
        _ => None,
    };
    let row = number.and_then(Dictionary::row);
    row.map_or(0.0, |row| engineering::to_unit(row, row.kind.widen(raw)))
}

/// A refused reboot has no answer, and for one that is about a parameter the parameter is named.
fn request_error(request: Request, error: RequestError) -> JsValue {
    match error {
        RequestError::NoAnswer => match request {
            Request::Read { number } | Request::Write { number, .. } => {
                thrown(NO_ANSWER, &format!("parameter {number}: {error}"))
            }
            Request::Reboot => thrown(NO_ANSWER, &format!("{error}: it is off the bus, or driving")),
            _ => thrown(NO_ANSWER, &error),
        },
        RequestError::Refused(refused) => refusal(&refused),
        RequestError::NotObeyed => thrown(REFUSED, &error),
    }
}

fn refusal(refusal: &Refusal) -> JsValue {
    match refusal.status {
        ParameterStatus::WrongState | ParameterStatus::Storage | ParameterStatus::NotEquipped => {
            thrown(REFUSED, refusal)
        }
        _ => thrown(PARAMETER, refusal),
    }
}

pub(crate) fn download_error(error: DownloadError) -> JsValue {
    match error {
        DownloadError::NoAnswer => thrown(NO_ANSWER, &error),
        DownloadError::Refused(refused) => refusal(&refused),
        _ => thrown(REFUSED, &error),
    }
}

/// An error that its name tells from others.
pub(crate) fn thrown(name: &str, message: &dyn Display) -> JsValue {
    let error = Error::new(&message.to_string());
    error.set_name(name);
    error.into()
}
