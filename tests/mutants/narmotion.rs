//! Tests of frames, candump and the words of NarMotion-X.
#![allow(dead_code)]

#[path = "../protocol/bench.rs"]
mod bench;
#[path = "../protocol/broadcast.rs"]
mod broadcast;
#[path = "../can/candump.rs"]
mod candump;
#[path = "../protocol/device.rs"]
mod device;
#[path = "../protocol/fields.rs"]
mod fields;
#[path = "../can/frame.rs"]
mod frame;
#[path = "../can/frames.rs"]
mod frames;
#[path = "../protocol/master.rs"]
mod master;
#[path = "../protocol/master_requests.rs"]
mod master_requests;
#[path = "../protocol/node.rs"]
mod node;
#[path = "../protocol/pair.rs"]
mod pair;
#[path = "../protocol/parameters.rs"]
mod parameters;
#[path = "../protocol/texts.rs"]
mod texts;
#[path = "../protocol/wire.rs"]
mod wire;
#[path = "../protocol/wire_update.rs"]
mod wire_update;
