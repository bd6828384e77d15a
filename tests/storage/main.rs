//! Tests of the flash: parameters that survive every power cut, and the log.

mod bench;
mod bulk;
mod code_flash;
mod code_flash_damage;
mod cuts;
mod device;
mod flash;
mod flips;
mod lasts;
mod log;
mod log_memory;
mod mailbox;
mod master;
mod node;
mod store;
mod support;
mod worn_out;
