//! What the hardware shows: samples, their scales, and what they mean in volts and amperes.

pub mod front_end;
pub mod measurement;
pub mod samples;
