//! The NarMotion-X protocol: dictionary, wire formats and node, through their public interfaces.

mod dictionary;
mod wire;
