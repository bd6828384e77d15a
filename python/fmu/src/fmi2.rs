//! FMI 2.0.

use crate::instance::{self, Log, OK, Status, not_offered};
use std::ffi::{CString, c_char, c_int, c_void};
use std::path::PathBuf;

/// Logger of the importer: environment, name of the instance, status, category, format, values.
type Logger = unsafe extern "C" fn(*mut c_void, *const c_char, Status, *const c_char, *const c_char, ...);

/// Functions of the importer.
#[repr(C)]
struct Callbacks {
    logger: Option<Logger>,
    allocate_memory: *const c_void,
    free_memory: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

/// Number of co-simulation among the types of an instance.
const CO_SIMULATION: c_int = 1;

#[unsafe(no_mangle)]
extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2SetDebugLogging(_: *mut c_void, _: c_int, _: usize, _: *const *const c_char) -> Status {
    OK
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    token: *const c_char,
    resources: *const c_char,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging: c_int,
) -> *mut c_void {
    // SAFETY: texts and callbacks are the importer's, and valid during this call; the functions longer.
    let (name, token, resources, callbacks) = unsafe {
        (instance::text(name), instance::text(token), instance::text(resources), callbacks.as_ref())
    };
    let (logger, environment) = callbacks.map_or((None, std::ptr::null_mut()), |c| (c.logger, c.environment));
    let name = CString::new(name.unwrap_or_default()).unwrap_or_default();
    let log: Log = Box::new(move |status, message| {
        if let Some(logger) = logger {
            // SAFETY: the importer's function and environment. The message is a value, not the format.
            unsafe {
                logger(
                    environment,
                    name.as_ptr(),
                    status,
                    c"error".as_ptr(),
                    c"%s".as_ptr(),
                    message.as_ptr(),
                );
            }
        }
    });
    if kind != CO_SIMULATION {
        log(instance::ERROR, c"there is co-simulation only");
        return std::ptr::null_mut();
    }
    instance::instantiate(resources.and_then(path), token, log)
}

/// Returns the path of a `file:` URI; a plain path is one, too.
fn path(uri: &str) -> Option<PathBuf> {
    let Some(rest) = uri.strip_prefix("file:") else { return Some(uri.into()) };
    let encoded = rest.strip_prefix("//localhost").or_else(|| rest.strip_prefix("//")).unwrap_or(rest);
    let (mut bytes, mut decoded) = (encoded.bytes(), Vec::new());
    while let Some(byte) = bytes.next() {
        decoded.push(match byte {
            b'%' => {
                let mut digit = || char::from(bytes.next()?).to_digit(16);
                (digit()? << 4 | digit()?) as u8
            }
            byte => byte,
        });
    }
    String::from_utf8(decoded).ok().map(PathBuf::from)
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2FreeInstance(c: *mut c_void) {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::free(c) };
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetupExperiment(
    c: *mut c_void,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start_time: f64,
    _stop_time_defined: c_int,
    _stop_time: f64,
) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |model| model.begin(start_time)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2EnterInitializationMode(c: *mut c_void) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |_| Ok(())) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2ExitInitializationMode(c: *mut c_void) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |_| Ok(())) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2Terminate(c: *mut c_void) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |_| Ok(())) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2Reset(c: *mut c_void) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |model| model.reset()) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetReal(c: *mut c_void, vr: *const u32, count: usize, values: *mut f64) -> Status {
    // SAFETY: an instance of the importer's, or null, and arrays of `count` elements.
    unsafe { instance::get(c, vr, values, count, |value| value) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetInteger(
    c: *mut c_void,
    vr: *const u32,
    count: usize,
    values: *mut c_int,
) -> Status {
    // SAFETY: as above.
    unsafe { instance::get(c, vr, values, count, |value| value as i64 as c_int) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetBoolean(
    c: *mut c_void,
    vr: *const u32,
    count: usize,
    values: *mut c_int,
) -> Status {
    // SAFETY: as above.
    unsafe { instance::get(c, vr, values, count, |value| c_int::from(value != 0.0)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetReal(c: *mut c_void, vr: *const u32, count: usize, values: *const f64) -> Status {
    // SAFETY: as above.
    unsafe { instance::set(c, vr, values, count, |value: f64| value) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetBoolean(
    c: *mut c_void,
    vr: *const u32,
    count: usize,
    values: *const c_int,
) -> Status {
    // SAFETY: as above.
    unsafe { instance::set(c, vr, values, count, f64::from) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetFMUstate(c: *mut c_void, state: *mut *mut c_void) -> Status {
    // SAFETY: an instance of the importer's, or null, and the place of a state.
    unsafe { instance::get_state(c, state) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetFMUstate(c: *mut c_void, state: *mut c_void) -> Status {
    // SAFETY: an instance and a state of the importer's, or null.
    unsafe { instance::set_state(c, state) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2FreeFMUstate(_c: *mut c_void, state: *mut *mut c_void) -> Status {
    // SAFETY: the place of a state, or null.
    unsafe { instance::free_state(state) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2DoStep(c: *mut c_void, time: f64, length: f64, _no_set_state: c_int) -> Status {
    // SAFETY: an instance of the importer's, or null.
    unsafe { instance::with(c, |model| model.step(time, length)) }
}

not_offered! {
    fmi2GetString fmi2SetInteger fmi2SetString
    fmi2SerializedFMUstateSize fmi2SerializeFMUstate fmi2DeSerializeFMUstate
    fmi2GetDirectionalDerivative fmi2SetRealInputDerivatives fmi2GetRealOutputDerivatives
    fmi2CancelStep fmi2GetStatus fmi2GetRealStatus fmi2GetIntegerStatus fmi2GetBooleanStatus fmi2GetStringStatus
}
