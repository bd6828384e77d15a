//! The eddyCAN protocol and the TX-Driver, through their public interfaces.

mod bench;
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
mod pdo;
mod random;
mod restart;
mod sdo;
mod wire;
