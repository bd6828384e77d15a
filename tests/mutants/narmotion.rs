//! Frames, candump and the words of NarMotion-X.
#![allow(dead_code)]

#[path = "../protocol/bench.rs"]
mod bench;
#[path = "../protocol/broadcast.rs"]
mod broadcast;
#[path = "../can/candump.rs"]
mod candump;
#[path = "../protocol/described.rs"]
mod described;
#[path = "../protocol/device.rs"]
mod device;
#[path = "../protocol/download_bench.rs"]
mod download_bench;
#[path = "../can/frames.rs"]
mod frames;
#[path = "../protocol/master.rs"]
mod master;
#[path = "../protocol/master_downloads.rs"]
mod master_downloads;
#[path = "../protocol/master_link.rs"]
mod master_link;
#[path = "../protocol/master_log.rs"]
mod master_log;
#[path = "../protocol/master_report.rs"]
mod master_report;
#[path = "../protocol/master_requests.rs"]
mod master_requests;
#[path = "../protocol/node.rs"]
mod node;
#[path = "../protocol/pair.rs"]
mod pair;
#[path = "../protocol/parameters.rs"]
mod parameters;
#[path = "../protocol/wire.rs"]
mod wire;
