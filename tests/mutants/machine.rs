//! Tests of state machine, faults and protection.
#![allow(dead_code)]

#[path = "../motor/acknowledgement.rs"]
mod acknowledgement;
#[path = "../motor/boot.rs"]
mod boot;
#[path = "../motor/build.rs"]
mod build;
#[path = "../motor/hall_drive.rs"]
mod hall_drive;
#[path = "../motor/limits.rs"]
mod limits;
#[path = "../motor/protection.rs"]
mod protection;
#[path = "../motor/quiet.rs"]
mod quiet;
#[path = "../motor/rotor.rs"]
mod rotor;
#[path = "../motor/safety.rs"]
mod safety;
#[path = "../motor/scripted.rs"]
mod scripted;
#[path = "../motor/support.rs"]
mod support;
#[path = "../motor/transition_table.rs"]
mod transition_table;
