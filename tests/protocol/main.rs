//! The NarMotion-X protocol: dictionary, wire formats and node, through their public interfaces.

mod bench;
mod dictionary;
mod node;
mod parameters;
mod wire;
