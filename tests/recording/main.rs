//! Recordings: what is written is read back, what was damaged is never believed, and what runs again is the same.

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
