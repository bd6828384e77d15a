//! State machine, faults and protection in a drive that turns a motor: for mutants that survive `machine`.
#![allow(dead_code)]

#[path = "../motor/bench.rs"]
mod bench;
#[path = "../motor/blocks_beside_a_drive.rs"]
mod blocks_beside_a_drive;
#[path = "../motor/flying_start.rs"]
mod flying_start;
#[path = "../motor/law.rs"]
mod law;
#[path = "../motor/live.rs"]
mod live;
#[path = "../motor/machine_rest.rs"]
mod machine_rest;
#[path = "../motor/machine_search.rs"]
mod machine_search;
#[path = "../motor/rotor.rs"]
mod rotor;
#[path = "../motor/scripted.rs"]
mod scripted;
#[path = "../motor/sensorless.rs"]
mod sensorless;
#[path = "../motor/session.rs"]
mod session;
#[path = "../motor/support.rs"]
mod support;
