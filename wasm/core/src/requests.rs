//! Requests to a drive, and their answers.

use crate::description;
use crate::dictionary::choice;
use crate::master::{Master, RPM_MAX, microseconds};
use js_sys::{Error, Object};
use narx_core::bus::narmotion::{DigitalOutputs, ParameterStatus};
use narx_core::dictionary::engineering::Misfit;
use narx_core::dictionary::number;
use narx_core::master::{
    Answer, DownloadError, ErrorKind, Job, JobError, Refusal, Request, RequestError, ScopeSetup,
};
use narx_wasm_values::error::{range_error, whole};
use narx_wasm_values::options::{Options, set};
use std::fmt::Display;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const TYPES: &str = r#"
/** An `Error` of a master. Its `name` tells the kind: no answer, a refusal by the drive or this master in its
 * present state, a parameter value that is not allowed, an image that is invalid for this drive, or a start that failed. */
export interface MasterError extends Error {
    readonly name: "NoAnswerError" | "RefusedError" | "ParameterError" | "ImageError" | "StartError";
}

/** A conversation of several messages: a start, which ends when the motor is in the loop of its mode; a hall
 * calibration, which ends when the motor is at rest again; a reboot, which ends when the drive is ready. */
export type JobName = "start" | "calibrate hall" | "reboot";

/** A conversation about the scope or the log: arm, force, or await the scope; capture a record; erase the log. */
export type RecordJobName = "arm scope" | "force scope" | "await scope" | "capture scope" | "erase log";

/** Settings of a record of the scope: raw values of its parameters. */
export interface RecordSetup {
    /** Recorded signals, a bit each; 0 records the inputs of every control tick instead. */
    channels: number;
    /** Samples of each signal; of a record of inputs, control ticks. */
    samples: number;
    /** Control ticks from one sample to the next. */
    prescaler: number;
    /** Samples from before the trigger, fewer than all. */
    before: number;
    /** Kind of the trigger (parameter 290); default 0 for none. */
    trigger?: number;
    /** Signal of the triggers 1 to 4, and their level in bases of the signal. */
    signal?: number;
    level?: number;
}

/** The answer to a request: the value that a parameter has now, in its unit (0 for other requests), or the
 * error. */
export type Answer = { readonly value: number; readonly error?: undefined } | { readonly error: MasterError };

/** State of the digital lines: each is an input, or an output of a level. */
export interface Outputs {
    /** Level of the output; `undefined`: an input. */
    dsio1?: boolean;
    dsio2?: boolean;
}
"#;

pub(crate) const NO_ANSWER: &str = "NoAnswerError";
pub(crate) const REFUSED: &str = "RefusedError";
pub(crate) const PARAMETER: &str = "ParameterError";
pub(crate) const START: &str = "StartError";

/// Jobs without arguments, by their names.
const JOBS: [(&str, Job); 3] =
    [("start", Job::Start { rpm: 0 }), ("calibrate hall", Job::CalibrateHall), ("reboot", Job::Reboot)];

#[wasm_bindgen]
impl Master {
    /// Queues a request to the drive. Answers come in the order of the requests. Throws a `MasterError` for a
    /// silent master, and while there are eight answers that were not taken.
    pub fn request(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "RequestName")] what: &JsValue,
    ) -> Result<(), JsValue> {
        let request = choice("request", what, &Request::NAMED)?;
        self.take(request)
    }

    /// Begins a job; one that is under way ends without a result. `rpm`: speed of a start, negative in
    /// reverse. Throws a `MasterError` for a silent master.
    pub fn begin(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "JobName")] job: &JsValue,
        rpm: Option<f64>,
    ) -> Result<(), JsValue> {
        let job = match choice("job", job, &JOBS)? {
            Job::Start { .. } => {
                Job::Start { rpm: whole("start", rpm.unwrap_or(f64::NAN), -RPM_MAX, RPM_MAX)? as i32 }
            }
            job => job,
        };
        self.core.begin(job).map_err(|refused| thrown(REFUSED, &refused))
    }

    /// Begins a job of the scope or the log; one that is under way ends without a result, jobs of the motor
    /// go on. `within`: longest wait for a record, s. Throws a `MasterError` for a silent master, a
    /// `RangeError` for a setting that is no whole number of 16 bits.
    #[wasm_bindgen(js_name = beginRecord)]
    pub fn begin_record(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "RecordJobName")] job: &JsValue,
        #[wasm_bindgen(unchecked_param_type = "RecordSetup | undefined")] setup: &JsValue,
        within: Option<f64>,
    ) -> Result<(), JsValue> {
        let setup = self.scope_setup(setup)?;
        let within = microseconds(within.unwrap_or(0.0));
        let jobs = [
            ("arm scope", Job::ArmScope(setup)),
            ("force scope", Job::ForceScope),
            ("await scope", Job::AwaitScope { within }),
            ("capture scope", Job::CaptureScope { setup, within }),
            ("erase log", Job::EraseLog),
        ];
        self.core.begin(choice("job", job, &jobs)?).map_err(|refused| thrown(REFUSED, &refused))
    }

    /// Returns whether the job of the scope or the log has ended in success. Throws a `MasterError` for one
    /// that has failed, a `RangeError` for a setting that does not fit.
    #[wasm_bindgen(js_name = pollRecord)]
    pub fn poll_record(&mut self) -> Result<bool, JsValue> {
        self.core.poll_record().transpose().map(|end| end.is_some()).map_err(|error| self.job_error(error))
    }

    /// Returns whether the job has ended in success. Throws a `MasterError` for one that has failed.
    #[wasm_bindgen(js_name = pollJob)]
    pub fn poll_job(&mut self) -> Result<bool, JsValue> {
        self.core.poll_job().transpose().map(|end| end.is_some()).map_err(|error| self.job_error(error))
    }

    /// True while a start waits until the drive accepts it.
    #[wasm_bindgen(getter, js_name = startPending)]
    pub fn start_pending(&mut self) -> bool {
        self.core.is_start_pending()
    }

    /// Requests a parameter's value.
    pub fn read(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ParameterName | number")] key: &JsValue,
    ) -> Result<(), JsValue> {
        let number = description::number(self.tables.as_ref(), key)?;
        self.take(Request::Read { number })
    }

    /// Requests to write a parameter, in its unit, rounded to the nearest step of its scale. Throws a
    /// `RangeError` for a value that is not allowed: outside the range, not a number, a fraction of a whole
    /// parameter.
    pub fn write(
        &mut self,
        #[wasm_bindgen(unchecked_param_type = "ParameterName | number")] key: &JsValue,
        value: f64,
    ) -> Result<(), JsValue> {
        let number = description::number(self.tables.as_ref(), key)?;
        let shape = description::shape(self.tables.as_ref(), number).ok_or(JsValue::UNDEFINED)?;
        let raw = shape.scale.entered(value).map_err(|refused| range_error(&refused))?;
        // Parameters of every type have 32 bits; the cast keeps them.
        self.take(Request::Write { number, raw: raw as i32 })
    }

    /// Requests factory values, except for the board's own parameters. `serial`: parameter 1 of the addressed
    /// board.
    #[wasm_bindgen(js_name = restoreFactory)]
    pub fn restore_factory(&mut self, serial: f64) -> Result<(), JsValue> {
        let serial = whole("serial", serial, 0.0, u16::MAX.into())? as u16;
        self.take(Request::RestoreFactory { serial })
    }

    /// Requests the digital lines to be inputs, or outputs of a level.
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

    /// Returns the next answer; `undefined` before it has come.
    #[wasm_bindgen(js_name = pollAnswer, unchecked_return_type = "Answer | undefined")]
    pub fn poll_answer(&mut self) -> JsValue {
        let Some(Answer { request, result }) = self.core.poll_answer() else { return JsValue::UNDEFINED };
        let shaped = Object::new();
        match result {
            Ok(raw) => set(&shaped, "value", self.answered(request, raw)),
            Err(error) => set(&shaped, "error", self.job_error(JobError::Request(request, error))),
        }
        shaped.into()
    }
}

impl Master {
    fn take(&mut self, request: Request) -> Result<(), JsValue> {
        self.core.request(request).map_err(|refused| thrown(REFUSED, &refused))
    }

    fn answered(&mut self, request: Request, raw: i32) -> f64 {
        let (Request::Read { number } | Request::Write { number, .. }) = request else { return 0.0 };
        if self.core.parameters().get(number).is_none() {
            self.others.retain(|(other, _)| *other != number);
            self.others.push((number, raw));
        }
        self.value(number, raw)
    }

    /// Settings of a record; nothing for `undefined`.
    fn scope_setup(&self, setup: &JsValue) -> Result<ScopeSetup, JsValue> {
        const NAMES: [&str; 7] = ["channels", "samples", "prescaler", "before", "trigger", "signal", "level"];
        let setup = Options::new("setup", setup, &NAMES)?;
        let word = |name| Ok::<_, JsValue>(setup.whole(name, 0.0, u16::MAX.into())?.unwrap_or(0.0) as u16);
        let byte = |name| Ok::<_, JsValue>(setup.whole(name, 0.0, u8::MAX.into())?.unwrap_or(0.0) as u8);
        let shape = description::shape(self.tables.as_ref(), number::SCOPE_TRIGGER_LEVEL);
        let level = match (shape, setup.number("level")?) {
            (Some(shape), Some(level)) => {
                shape.scale.entered(level).map_err(|refused| range_error(&refused))? as i32
            }
            _ => 0,
        };
        Ok(ScopeSetup {
            channels: setup.whole("channels", 0.0, u32::MAX.into())?.unwrap_or(0.0) as u32,
            samples: word("samples")?,
            prescaler: word("prescaler")?,
            before: word("before")?,
            trigger: byte("trigger")?,
            signal: byte("signal")?,
            level,
        })
    }

    /// Converts the error of a job, or of one request. An error about a parameter has the drive's own name
    /// and range.
    pub(crate) fn job_error(&self, error: JobError) -> JsValue {
        if let JobError::Request(_, RequestError::Refused(refused)) = error {
            return self.refusal(&refused);
        }
        match error.kind() {
            ErrorKind::Range => range_error(&error),
            ErrorKind::Start => thrown(START, &error),
            ErrorKind::Refused => thrown(REFUSED, &error),
            ErrorKind::NoAnswer => thrown(NO_ANSWER, &error),
            ErrorKind::Parameter => thrown(PARAMETER, &error),
        }
    }

    /// Converts the refusal of a parameter, with the name and range of the drive's description.
    fn refusal(&self, refused: &Refusal) -> JsValue {
        let described =
            self.tables.as_ref().and_then(|tables| description::shape(Some(tables), refused.number));
        let Some(shape) = described else { return refusal(refused) };
        let raw = refused.offered.map(|raw| shape.kind.widen(raw)).unwrap_or_default();
        let value = shape.scale.to_unit(raw);
        match refused.status {
            ParameterStatus::OutOfRange if !(shape.scale.min..=shape.scale.max).contains(&raw) => {
                thrown(PARAMETER, &Misfit { scale: shape.scale, value })
            }
            status => thrown(kind(status), &format!("{}: {status}", shape.scale)),
        }
    }
}

fn refusal(refusal: &Refusal) -> JsValue {
    thrown(kind(refusal.status), refusal)
}

const fn kind(status: ParameterStatus) -> &'static str {
    match status {
        ParameterStatus::WrongState | ParameterStatus::Storage | ParameterStatus::NotEquipped => REFUSED,
        _ => PARAMETER,
    }
}

pub(crate) fn download_error(error: DownloadError) -> JsValue {
    match error {
        DownloadError::NoAnswer => thrown(NO_ANSWER, &error),
        DownloadError::Refused(refused) => refusal(&refused),
        _ => thrown(REFUSED, &error),
    }
}

/// Returns an error with this `name`.
pub(crate) fn thrown(name: &str, message: &dyn Display) -> JsValue {
    let error = Error::new(&message.to_string());
    error.set_name(name);
    error.into()
}
