//! The flash: parameters that survive every power cut, and the log.

mod cuts;
mod flash;
mod flips;
mod store;
mod support;
