//! Bootloader of a narx drive, over any NOR flash: the same code on the host, in the emulator and on a board.
//!
//! ```text
//!             bootloader                                      application
//!                 |                                                |
//!   boot(flash, map, board) -> Outcome                       Slot::new(flash, map, hardware)
//!        swap, revert, verify                                begin, erase, write, inspect, mark, confirm
//!                 |                                                |
//!                 +---- state pages: Mark (embassy-boot's) --------+
//!
//!   image    header and body           verify  hardware, length, Ed25519ph signature
//!   version  their order               map     where things lie in the flash
//!   key      whom the board believes   sign    makes images (feature `sign`, host)
//!   hardware the boards' ids
//! ```
//!
//! A bootloader is `match boot(&mut flash, &MAP, &Board { hardware, key: key::chosen() })`: with
//! [`Outcome::Run`] it sets the vector table to [`Map::entry`], loads the stack pointer from its first word
//! and enters at its second; with [`Outcome::Stay`], and with a [`Failure`], it enters nothing, says so with
//! whatever the board has for it, and waits for a reset.
//!
//! A flash without room for two slots has [one](one_slot), and a bootloader that receives.
//!
//! An application (feature `node`) makes a `Server` over its [`Slot`], gives its `slots()` to
//! `Node::attach_update` at power-up, and in every pass of its loop one of `Node::poll_update` to
//! `Server::execute`, whose report goes to `Node::handle_update`. An erase takes a page's time (22 ms on the
//! ST board); nothing of it happens beside a motor that turns.
#![no_std]
#![forbid(unsafe_code)]

mod boot;
pub mod hardware;
mod image;
pub mod key;
mod map;
mod mark;
pub mod one_slot;
#[cfg(feature = "node")]
mod serve;
#[cfg(feature = "sign")]
pub mod sign;
mod slot;
mod verify;
mod version;

pub use boot::{Event, Failure, Outcome, boot};
pub use image::{BODY_ALIGNMENT, HEADER_LENGTH, Header, HeaderError, SIGNATURE_LENGTH, SIGNED_LENGTH};
pub use key::Key;
pub use map::{Map, MapError};
pub use mark::Mark;
pub use one_slot::OneSlot;
#[cfg(feature = "node")]
pub use serve::{Inside, Programs, Server};
pub use slot::{Condition, Slot, SlotError, Verdict};
pub use verify::{Board, ImageError, Refused, Signatory};
pub use version::{NoVersion, Version};
