//! The narx drive on ST's B-G431B-ESC1 (STM32G431CB, 170 MHz).
//!
//! ```text
//!  pure, tested on the host                          registers, on the board alone (chip)
//!  timing  counts, instants, dead time      ───────> TIM1, TIM4
//!  analog  codes to units                   <─────── ADC1, ADC2, op-amps, comparators
//!  edges   captures to edges                <─────── TIM4
//!  can     bit timing, frames               <──────> FDCAN1
//!  pins, flash_map                          ───────> ports, flash
//! ```
//!
//! docs/B-G431B-ESC1.md has the wiring, the sources of every figure, and what nobody has seen on silicon yet.
#![no_std]

pub mod analog;
pub mod can;
#[cfg(target_os = "none")]
pub mod chip;
pub mod edges;
pub mod flash_map;
pub mod pins;
pub mod timing;

use narx_core::motor::{Board, Equipment};

/// Properties of the board on which the control core relies.
pub const BOARD: Board = Board {
    tick_rate: timing::TICK_RATE,
    earliest: EARLIEST,
    dead_time_ns: timing::DEAD_TIME_NS,
    bridge_milliohm: BRIDGE_MILLIOHM,
    hall_capture: true,
    comparator_capture: false,
    equipment: Equipment::DIGITAL_INPUTS,
    front_end: analog::FRONT_END,
};

/// Two STL180N6F7 of at most 2.4 milliohm each (their data sheet).
const BRIDGE_MILLIOHM: u16 = 5;

/// 25 us: 2.6 us of conversions from the boundary on, and a control tick in this image's size-first code.
pub const EARLIEST: u16 = timing::instant(timing::counts(25_000));
/// From the bus voltage's conversion to phase C's: three conversions of 25 clocks of 42.5 MHz.
pub const SKEW: u16 = 1_157;
