//! Coefficients of a motor's control, from parameters.

use crate::board::narx_board_t;
use crate::device::{self, narx_stored_t};
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::motor::drive::BEHAVIOUR_VERSION;
use narx_core::motor::{BuildError, Coefficients};

/// Rises whenever coefficients of an earlier library would be wrong for this one: what `narx coefficients`
/// prints compares it.
pub const NARX_COEFFICIENTS_VERSION: u16 = 15;

const _: () = assert!(
    NARX_COEFFICIENTS_VERSION == BEHAVIOUR_VERSION,
    "the header has this constant as a plain number: set it to the core's"
);

/// Parameter that does not fit the others.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_parameter_error_t {
    /// Smallest raw value that fits the others.
    pub min: i64,
    /// Largest raw value that fits the others.
    pub max: i64,
    /// Its raw value.
    pub value: i32,
    /// Its number: a NARX_PARAMETER_*.
    pub number: u16,
}

/// Builds coefficients from parameters: the factory's, and `count` others, raw with the units and scales of
/// PROTOCOL.md. `stored` may be NULL if `count` is 0, `board` for the default board. Parameters that do not
/// fit each other give NARX_ERROR_PARAMETERS; `error`, which may be NULL, then names one. Not for an
/// interrupt: it divides.
///
/// It takes 11 KB of flash, or 30 in a library with the texts of the parameters. Where the parameters are
/// known when the program is built, let `narx coefficients` print what this would build.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_coefficients_build(
    coefficients: *mut Coefficients,
    board: *const narx_board_t,
    stored: *const narx_stored_t,
    count: usize,
    error: *mut narx_parameter_error_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        match Coefficients::build(&device::parameters(stored, count)?, &device::board(board)?) {
            Ok(built) => pointer::write(coefficients, built),
            Err(misfit) => {
                pointer::write_unless_null(error, misfit.into())?;
                Err(NARX_ERROR_PARAMETERS)
            }
        }
    };
    pointer::status(run())
}

impl From<BuildError> for narx_parameter_error_t {
    fn from(BuildError { parameter, raw, min, max }: BuildError) -> Self {
        Self { min, max, value: raw, number: parameter }
    }
}
