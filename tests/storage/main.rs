//! The flash: parameters that survive every power cut, and the log.

mod cuts;
mod device;
mod flash;
mod flips;
mod log;
mod node;
mod store;
mod support;
