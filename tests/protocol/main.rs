//! The NarMotion-X protocol: dictionary, wire formats and node, through their public interfaces.

mod bench;
mod broadcast;
mod description;
mod device;
mod device_halves;
mod dictionary;
mod document;
mod inputs;
mod messages;
mod node;
mod parameters;
mod wire;
