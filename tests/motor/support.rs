//! What many tests need: coefficients with what a test changes.

use narx_core::dictionary::Parameters;
use narx_core::motor::{Board, Coefficients};

/// Factory parameters with these raw values changed, on the bench's board.
pub(crate) fn coefficients(changes: &[(u16, i32)]) -> Coefficients {
    coefficients_on(&Board::BENCH, changes)
}

/// The same on another board.
pub(crate) fn coefficients_on(board: &Board, changes: &[(u16, i32)]) -> Coefficients {
    let mut parameters = Parameters::new();
    for (number, raw) in changes {
        parameters.set(*number, *raw).unwrap();
    }
    Coefficients::build(&parameters, board).unwrap()
}
