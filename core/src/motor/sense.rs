//! Samples of the hardware, their scales, and their meaning in volts and amperes.

pub mod front_end;
pub mod measurement;
pub mod samples;
