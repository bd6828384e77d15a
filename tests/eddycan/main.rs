//! Tests of the eddyCAN protocol and the TX-Driver, through their public interfaces.

mod bench;
mod bitrates;
mod bus;
mod comparators;
mod document;
mod eds;
mod encoder;
mod errors;
mod filters;
mod heartbeat;
mod master;
mod network;
mod objects;
mod over_the_bus;
mod pdo;
mod random;
mod restart;
mod sdo;
mod sensors;
mod texts;
mod wire;
mod wired;
mod with_a_drive;
