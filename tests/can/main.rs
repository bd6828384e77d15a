//! Tests of the CAN bus model (bits, arbitration, errors and load), and of logs of a bus.

mod arbitration;
mod bits;
mod candump;
mod errors;
mod frame;
mod frames;
mod log;
mod slcan;
