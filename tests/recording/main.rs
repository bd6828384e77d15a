//! Tests of recordings: written data are read back, damage is always detected, and a replay gives the same
//! results.

mod corruption;
mod digest;
mod format;
mod outputs;
mod parity;
mod replay;
mod round_trip;
mod support;
mod transcript;
mod vectors;
