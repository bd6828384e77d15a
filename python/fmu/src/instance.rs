//! An instance of the model, and what both versions of the standard do with it.

use narx_host::fmu::{self, Model};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::{fs, slice};

/// Status of a call, with the standard's numbers.
pub(crate) type Status = c_int;
pub(crate) const OK: Status = 0;
pub(crate) const ERROR: Status = 3;

/// File of the drive among the resources.
const FILE: &str = "drive.json";

/// Function that takes a message: its status and its text.
pub(crate) type Log = Box<dyn Fn(Status, &CStr)>;

/// An instance: the importer has its address.
pub(crate) struct Instance {
    model: Model,
    log: Log,
}

/// Makes an instance from the resources of an FMU, if `token` belongs to them. Returns null with a message if
/// it cannot.
pub(crate) fn instantiate(resources: Option<PathBuf>, token: Option<&str>, log: Log) -> *mut c_void {
    match read(resources.as_deref(), token) {
        Ok(model) => Box::into_raw(Box::new(Instance { model, log })).cast(),
        Err(reason) => {
            tell(&log, &reason);
            std::ptr::null_mut()
        }
    }
}

fn read(resources: Option<&Path>, token: Option<&str>) -> Result<Model, String> {
    let path = resources.ok_or("the path of the resources: must be text")?.join(FILE);
    let file = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let own = fmu::token(&file);
    if token != Some(own.as_str()) {
        return Err(format!("token {}: must be {own}, that of {FILE}", token.unwrap_or_default()));
    }
    Model::new(&file)
}

fn tell(log: &Log, reason: &str) {
    if let Ok(reason) = CString::new(reason.replace('\0', " ")) {
        log(ERROR, &reason);
    }
}

/// Calls `act` with the instance at `pointer`; tells the importer why it fails.
///
/// # Safety
/// `pointer` is null, or what [`instantiate`] returned and [`free`] did not take.
pub(crate) unsafe fn with(
    pointer: *mut c_void,
    act: impl FnOnce(&mut Model) -> Result<(), String>,
) -> Status {
    // SAFETY: as the caller promises. The standard forbids calls of one instance at the same time.
    let Some(instance) = (unsafe { pointer.cast::<Instance>().as_mut() }) else { return ERROR };
    match act(&mut instance.model) {
        Ok(()) => OK,
        Err(reason) => {
            tell(&instance.log, &reason);
            ERROR
        }
    }
}

/// Ends an instance.
///
/// # Safety
/// As [`with`]; nobody uses it afterwards.
pub(crate) unsafe fn free(pointer: *mut c_void) {
    if !pointer.is_null() {
        // SAFETY: it is a box of `instantiate`.
        drop(unsafe { Box::from_raw(pointer.cast::<Instance>()) });
    }
}

/// Reads variables: `values[i]` becomes `convert` of the value of `references[i]`.
///
/// # Safety
/// As [`with`]; both arrays have `count` elements.
pub(crate) unsafe fn get<T>(
    pointer: *mut c_void,
    references: *const u32,
    values: *mut T,
    count: usize,
    convert: impl Fn(f64) -> T,
) -> Status {
    if count > 0 && (references.is_null() || values.is_null()) {
        return ERROR;
    }
    let act = |model: &mut Model| {
        for place in 0..count {
            // SAFETY: the arrays have so many elements; those of `values` need not be initialised.
            let reference = unsafe { references.add(place).read() };
            let value = model.value(reference);
            let value = value.ok_or_else(|| format!("value reference {reference}: no variable has it"))?;
            // SAFETY: as above.
            unsafe { values.add(place).write(convert(value)) };
        }
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(pointer, act) }
}

/// Sets inputs: that of `references[i]` to `convert` of `values[i]`.
///
/// # Safety
/// As [`with`]; both arrays have `count` elements.
pub(crate) unsafe fn set<T: Copy>(
    pointer: *mut c_void,
    references: *const u32,
    values: *const T,
    count: usize,
    convert: impl Fn(T) -> f64,
) -> Status {
    if count > 0 && (references.is_null() || values.is_null()) {
        return ERROR;
    }
    let act = |model: &mut Model| {
        if count == 0 {
            return Ok(());
        }
        // SAFETY: the arrays have so many elements, and are not null.
        let pairs =
            unsafe { (slice::from_raw_parts(references, count), slice::from_raw_parts(values, count)) };
        pairs.0.iter().zip(pairs.1).try_for_each(|(reference, value)| model.set(*reference, convert(*value)))
    };
    // SAFETY: as the caller promises.
    unsafe { with(pointer, act) }
}

/// Copies the model into `*state`, or over the copy that is there.
///
/// # Safety
/// As [`with`]; `*state` is null or a copy that this function made.
pub(crate) unsafe fn get_state(pointer: *mut c_void, state: *mut *mut c_void) -> Status {
    let act = |model: &mut Model| {
        // SAFETY: as the caller promises.
        let state = unsafe { state.as_mut() }.ok_or("FMU state: must not be null")?;
        // SAFETY: as the caller promises.
        match unsafe { state.cast::<Model>().as_mut() } {
            Some(copy) => *copy = model.clone(),
            None => *state = Box::into_raw(Box::new(model.clone())).cast(),
        }
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(pointer, act) }
}

/// Continues with a copy of [`get_state`].
///
/// # Safety
/// As [`with`]; `state` is null or such a copy.
pub(crate) unsafe fn set_state(pointer: *mut c_void, state: *mut c_void) -> Status {
    let act = |model: &mut Model| {
        // SAFETY: as the caller promises.
        *model = unsafe { state.cast::<Model>().as_ref() }.ok_or("FMU state: must not be null")?.clone();
        Ok(())
    };
    // SAFETY: as the caller promises.
    unsafe { with(pointer, act) }
}

/// Ends a copy of [`get_state`]; `*state` is null afterwards.
///
/// # Safety
/// `state` is null, or `*state` is null or such a copy.
pub(crate) unsafe fn free_state(state: *mut *mut c_void) -> Status {
    // SAFETY: as the caller promises.
    let Some(state) = (unsafe { state.as_mut() }) else { return OK };
    if !state.is_null() {
        // SAFETY: it is a box of `get_state`.
        drop(unsafe { Box::from_raw(state.cast::<Model>()) });
    }
    *state = std::ptr::null_mut();
    OK
}

/// Returns the importer's text; `None` if it is null or no UTF-8.
///
/// # Safety
/// `text` is null or ends with a zero, and outlives the result.
pub(crate) unsafe fn text<'a>(text: *const c_char) -> Option<&'a str> {
    if text.is_null() {
        return None;
    }
    // SAFETY: as the caller promises.
    unsafe { CStr::from_ptr(text) }.to_str().ok()
}

/// Exports functions of the standard that the description of this FMU does not offer: they fail. They take no
/// arguments here, which the calling convention of C allows.
macro_rules! not_offered {
    ($($name:ident)*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name() -> $crate::instance::Status {
            $crate::instance::ERROR
        }
    )*};
}
pub(crate) use not_offered;
