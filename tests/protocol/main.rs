//! The NarMotion-X protocol: dictionary, wire formats and node, through their public interfaces.

mod bench;
mod dictionary;
mod document;
mod node;
mod parameters;
mod wire;
