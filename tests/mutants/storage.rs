//! Tests of the storage.
#![allow(dead_code)]

#[path = "../storage/bulk.rs"]
mod bulk;
#[path = "../storage/code_flash.rs"]
mod code_flash;
#[path = "../storage/code_flash_damage.rs"]
mod code_flash_damage;
#[path = "../storage/cuts.rs"]
mod cuts;
#[path = "../storage/device.rs"]
mod device;
#[path = "../storage/flash.rs"]
mod flash;
#[path = "../storage/flips.rs"]
mod flips;
#[path = "../storage/log.rs"]
mod log;
#[path = "../storage/log_memory.rs"]
mod log_memory;
#[path = "../storage/mailbox.rs"]
mod mailbox;
#[path = "../storage/node.rs"]
mod node;
#[path = "../storage/store.rs"]
mod store;
#[path = "../storage/support.rs"]
mod support;
#[path = "../storage/worn_out.rs"]
mod worn_out;
