//! The narx drive as an image for a microcontroller.
//!
//! ```text
//!   control interrupt, highest priority         background loop
//!   board::TickSide ─> shell::Control           shell::Background <─> board::BackgroundSide
//!      samples, PWM         │ narx_core::device queues │         CAN, slow inputs, watchdog, reboot
//!                           └─────────────────────────┘
//! ```
//!
//! [`shell`] holds what every board does alike and nothing about control; [`board`] says what a board gives;
//! [`self_test`] is what boards test of themselves; [`boards`] are those that need no silicon, [`owned`] is
//! how an interrupt gets what is its own. A board on silicon is a package of its own.
#![no_std]

pub mod board;
pub mod boards;
pub mod owned;
pub mod self_test;
pub mod shell;
