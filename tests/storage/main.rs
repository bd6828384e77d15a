//! The flash: parameters that survive every power cut, and the log.

mod bench;
mod cuts;
mod device;
mod flash;
mod flips;
mod log;
mod node;
mod store;
mod support;
