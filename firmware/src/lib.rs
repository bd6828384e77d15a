//! The narx drive as an image for a microcontroller.
//!
//! ```text
//!   control interrupt, highest priority         background loop
//!   board::TickSide ─> shell::Control           shell::Background <─> board::BackgroundSide
//!      samples, PWM         │ narx_core::device queues │         CAN, slow inputs, watchdog, reboot
//!                           └─────────────────────────┘
//! ```
//!
//! [`shell`] holds what every board does alike and nothing about control; [`board`] says what a board gives; [`boards`]
//! are the boards.
#![no_std]

pub mod board;
pub mod boards;
pub mod shell;
