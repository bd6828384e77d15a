//! Helpers of many tests: coefficients with changed parameters.

use narx_core::dictionary::Parameters;
use narx_core::motor::{Board, Coefficients};

/// Coefficients from factory parameters with these raw values changed, on the bench's board.
pub(crate) fn coefficients(changes: &[(u16, i32)]) -> Coefficients {
    coefficients_on(&Board::BENCH, changes)
}

/// Coefficients as [`coefficients`], on another board.
pub(crate) fn coefficients_on(board: &Board, changes: &[(u16, i32)]) -> Coefficients {
    let mut parameters = Parameters::new();
    for (number, raw) in changes {
        parameters.set(*number, *raw).unwrap();
    }
    Coefficients::build(&parameters, board).unwrap()
}
