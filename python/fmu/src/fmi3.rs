//! FMI 3.0.

use crate::instance::{self, Log, OK, Status, not_offered};
use std::ffi::{c_char, c_void};
use std::path::PathBuf;

/// Logger of the importer: environment, status, category, message.
type Logger = unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char);

#[unsafe(no_mangle)]
extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi3SetDebugLogging(_: *mut c_void, _: bool, _: usize, _: *const *const c_char) -> Status {
    OK
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
    _visible: bool,
    _logging: bool,
    _event_mode: bool,
    _early_return: bool,
    _intermediate: *const u32,
    _intermediate_count: usize,
    environment: *mut c_void,
    logger: Option<Logger>,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    // SAFETY: texts of the importer's, valid during this call.
    let (token, resources) = unsafe { (instance::text(token), instance::text(resources)) };
    let log: Log = Box::new(move |status, message| {
        if let Some(logger) = logger {
            // SAFETY: the importer's function and environment, valid as long as the instance.
            unsafe { logger(environment, status, c"error".as_ptr(), message.as_ptr()) };
        }
    });
    instance::instantiate(resources.map(PathBuf::from), token, log)
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateModelExchange() -> *mut c_void {
    std::ptr::null_mut()
}

#[unsafe(no_mangle)]
extern "C" fn fmi3InstantiateScheduledExecution() -> *mut c_void {
    std::ptr::null_mut()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeInstance(c: *mut c_void) {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::free(c) };
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3EnterInitializationMode(
    c: *mut c_void,
    _tolerance_defined: bool,
    _tolerance: f64,
    start_time: f64,
    _stop_time_defined: bool,
    _stop_time: f64,
) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |model| model.begin(start_time)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3ExitInitializationMode(c: *mut c_void) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |_| Ok(())) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Terminate(c: *mut c_void) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |_| Ok(())) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3Reset(c: *mut c_void) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |model| model.reset()) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFloat64(
    c: *mut c_void,
    vr: *const u32,
    count: usize,
    values: *mut f64,
    _values_count: usize,
) -> Status {
    // SAFETY: an instance of the importer's, or null, and arrays of `count` elements: no variable is an
    // array.
    unsafe { instance::get(c, vr, values, count, |value| value) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetInt32(
    c: *mut c_void,
    vr: *const u32,
    count: usize,
    values: *mut i32,
    _values_count: usize,
) -> Status {
    // SAFETY: as above.
    unsafe { instance::get(c, vr, values, count, |value| value as i64 as i32) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetBoolean(
    c: *mut c_void,
    vr: *const u32,
    count: usize,
    values: *mut bool,
    _values_count: usize,
) -> Status {
    // SAFETY: as above.
    unsafe { instance::get(c, vr, values, count, |value| value != 0.0) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFloat64(
    c: *mut c_void,
    vr: *const u32,
    count: usize,
    values: *const f64,
    _values_count: usize,
) -> Status {
    // SAFETY: as above.
    unsafe { instance::set(c, vr, values, count, |value: f64| value) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetBoolean(
    c: *mut c_void,
    vr: *const u32,
    count: usize,
    values: *const u8,
    _values_count: usize,
) -> Status {
    // SAFETY: as above; a byte may be any number, a bool may not.
    unsafe { instance::set(c, vr, values, count, |value: u8| f64::from(u8::from(value != 0))) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3GetFMUState(c: *mut c_void, state: *mut *mut c_void) -> Status {
    // SAFETY: an instance of the importer's, or null, and the place of a state.
    unsafe { instance::get_state(c, state) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3SetFMUState(c: *mut c_void, state: *mut c_void) -> Status {
    // SAFETY: an instance and a state of the importer's, or null.
    unsafe { instance::set_state(c, state) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3FreeFMUState(_c: *mut c_void, state: *mut *mut c_void) -> Status {
    // SAFETY: the place of a state, or null.
    unsafe { instance::free_state(state) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi3DoStep(
    c: *mut c_void,
    time: f64,
    length: f64,
    _no_set_state: bool,
    event_handling_needed: *mut bool,
    terminate_simulation: *mut bool,
    early_return: *mut bool,
    last_successful_time: *mut f64,
) -> Status {
    // SAFETY: an instance of the importer's, or null.
    let status = unsafe { instance::with(c, |model| model.step(time, length)) };
    for flag in [event_handling_needed, terminate_simulation, early_return] {
        if !flag.is_null() {
            // SAFETY: the importer's place for an answer.
            unsafe { flag.write(false) };
        }
    }
    if !last_successful_time.is_null() {
        // SAFETY: the importer's place for an answer.
        unsafe { last_successful_time.write(if status == OK { time + length } else { time }) };
    }
    status
}

not_offered! {
    fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetUInt32 fmi3GetInt64 fmi3GetUInt64
    fmi3GetString fmi3GetBinary fmi3GetClock
    fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8 fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetInt64
    fmi3SetUInt64 fmi3SetString fmi3SetBinary fmi3SetClock
    fmi3GetNumberOfVariableDependencies fmi3GetVariableDependencies
    fmi3SerializedFMUStateSize fmi3SerializeFMUState fmi3DeserializeFMUState
    fmi3GetDirectionalDerivative fmi3GetAdjointDerivative fmi3GetOutputDerivatives
    fmi3EnterConfigurationMode fmi3ExitConfigurationMode fmi3EnterEventMode fmi3EnterStepMode
    fmi3GetIntervalDecimal fmi3GetIntervalFraction fmi3GetShiftDecimal fmi3GetShiftFraction
    fmi3SetIntervalDecimal fmi3SetIntervalFraction fmi3SetShiftDecimal fmi3SetShiftFraction
    fmi3EvaluateDiscreteStates fmi3UpdateDiscreteStates fmi3EnterContinuousTimeMode fmi3CompletedIntegratorStep
    fmi3SetTime fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators
    fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates fmi3GetNumberOfEventIndicators
    fmi3GetNumberOfContinuousStates fmi3ActivateModelPartition
}
