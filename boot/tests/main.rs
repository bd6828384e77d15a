//! Programming over the bus: images, bootloader, slot, and the protocol that fills it.

mod bench;
mod cuts;
mod failures;
mod key;
mod map;
mod master;
mod node;
mod one_slot;
mod slots;
mod support;
mod texts;
mod wire;
