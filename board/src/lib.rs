//! The traits that a board implements to carry the narx drive, and the code that all boards share.
//!
//! ```text
//!   control interrupt, highest priority         background loop or task
//!   side::TickSide ──> shell::Control           shell::Background <─> side::BackgroundSide
//!      samples, PWM         │ narx_core::device queues │         CAN, slow inputs, watchdog, reboot
//!                           └─────────────────────────┘
//! ```
//!
//! A board implements the two traits of [`side`]. The flash comes in as `embedded_storage`'s traits, which
//! `narx_core::storage` takes. [`shell`] holds what every board does alike and nothing about control,
//! [`owned`] is how an interrupt gets what is its own, [`self_test`] is what boards test of themselves while
//! they run, and [`stm32`] has the patterns of the bridge as words of an STM32's advanced timer.
//!
//! [`check`] comes before all of these: it measures on a new board what its description,
//! [`narx_core::motor::Board`], says, and names what is wrong.
#![no_std]
#![forbid(unsafe_code)]

pub mod check;
pub mod owned;
pub mod self_test;
pub mod shell;
pub mod side;
pub mod stm32;
