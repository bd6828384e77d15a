//! The flash: parameters that survive every power cut, and the log.

mod bench;
mod bulk;
mod cuts;
mod device;
mod flash;
mod flips;
mod log;
mod maps;
mod master;
mod node;
mod store;
mod support;
