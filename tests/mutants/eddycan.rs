//! Tests of the messages of eddyCAN.
#![allow(dead_code)]

#[path = "../eddycan/bench.rs"]
mod bench;
#[path = "../eddycan/comparators.rs"]
mod comparators;
#[path = "../eddycan/encoder.rs"]
mod encoder;
#[path = "../eddycan/errors.rs"]
mod errors;
#[path = "../eddycan/filters.rs"]
mod filters;
#[path = "../eddycan/heartbeat.rs"]
mod heartbeat;
#[path = "../eddycan/master.rs"]
mod master;
#[path = "../eddycan/network.rs"]
mod network;
#[path = "../eddycan/objects.rs"]
mod objects;
#[path = "../eddycan/pdo.rs"]
mod pdo;
#[path = "../eddycan/random.rs"]
mod random;
#[path = "../eddycan/restart.rs"]
mod restart;
#[path = "../eddycan/sdo.rs"]
mod sdo;
#[path = "../eddycan/texts.rs"]
mod texts;
#[path = "../eddycan/wire.rs"]
mod wire;
