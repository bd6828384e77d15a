//! The NarMotion-X protocol: dictionary, wire formats and node, through their public interfaces.

mod bench;
mod broadcast;
mod bus_errors;
mod described;
mod description;
mod device;
mod device_halves;
mod dictionary;
mod document;
mod download_bench;
mod flood;
mod inputs;
mod master;
mod master_bench;
mod master_downloads;
mod master_link;
mod master_log;
mod master_report;
mod master_requests;
mod messages;
mod node;
mod pair;
mod parameters;
mod scope;
mod wire;
mod wired;
