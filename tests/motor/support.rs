//! What many tests need: coefficients with what a test changes, a bench under a master.

use narx_core::dictionary::Parameters;
use narx_core::master::Master;
use narx_core::motor::{Board, Coefficients};
use narx_sim::bench::Bench;

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

/// One tick of a bench that a master commands; what the drive says is not heard.
pub(crate) fn commanded_tick(bench: &mut Bench, master: &mut Master) {
    while let Some(frame) = master.poll_frame(bench.now_ns() / 1000) {
        bench.send(frame).unwrap();
    }
    bench.step();
    while bench.receive().is_some() || bench.overhear().is_some() {}
}
