//! From angle and speed to the switches: steps, the instants at which they change, and the answer of the
//! tick.

pub mod commutation;
pub mod commutator;
pub mod pulses;
pub mod pwm;
