//! Inputs of the control tick: raw converter codes, hall code, time-stamped edges and digital lines.

use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Edges that one period can carry; more are counted in [`Samples::edges_lost`].
pub const EDGES_MAX: usize = 4;

/// Everything the tick `tick` knows of the outside, measured in period `tick` at the instant that the
/// previous [`PwmCommand`](crate::motor::PwmCommand) asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Samples {
    /// Number of this PWM period since power-up.
    pub tick: u64,
    /// Terminal voltages of phases A, B, C against ground, converter codes.
    pub phase_voltage: [u16; 3],
    /// Bus voltage, converter code.
    pub bus_voltage: u16,
    /// Bus current, converter code; see `current_mode`.
    pub bus_current: u16,
    /// Part of the period in which the phase voltages were sampled.
    pub sample_mode: SampleMode,
    /// The meaning of `bus_current`.
    pub current_mode: CurrentMode,
    /// From the bus voltage's conversion to phase C's, in 1/65 536 of a period (A and B lie evenly between).
    pub skew: u16,
    /// Hall lines at the sampling instant: bit 0 = A, bit 1 = B, bit 2 = C.
    pub hall: u8,
    /// Edges captured during the whole of period `tick - 1`, oldest first.
    pub edges: Vec<Edge, EDGES_MAX>,
    /// Edges of that period that found no room; the hall level finds what they would have shown, a tick
    /// later.
    pub edges_lost: u8,
    /// Digital inputs at the sampling instant.
    pub lines: Lines,
}

/// Which part of the PWM cycle the phase voltages show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum SampleMode {
    /// In the off-time: referred to ground or to the mean of the three phases.
    #[default]
    OffTime,
    /// In the middle of the on-time: referred to half the bus voltage.
    OnTime,
}

/// The meaning of the bus current's reading. Recordings keep it, but the drive ignores it and takes every
/// reading for [`CurrentMode::Average`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum CurrentMode {
    /// Mean DC-link current over the last period.
    #[default]
    Average,
    /// Sampled in the middle of the on-time: the phase current.
    OnTime,
}

/// One time-stamped edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edge {
    /// Instant of the edge, in 1/65 536 of the period that has just ended.
    pub instant: u16,
    /// The line or comparator that changed.
    pub source: EdgeSource,
    /// The three lines after the edge: bit 0 = A, bit 1 = B, bit 2 = C.
    pub code: u8,
}

/// Source of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum EdgeSource {
    /// A hall line.
    Hall,
    /// A back-EMF comparator.
    Comparator,
}

bitflags::bitflags! {
    /// Digital inputs, true = asserted.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
    pub struct Lines: u8 {
        /// The gate driver reports a fault (fault bit 5).
        const DRIVER_FAULT = 1 << 0;
        /// The hardware break input has tripped (fault bit 27).
        const EMERGENCY = 1 << 1;
        /// DSIO1 as an input.
        const DSI1 = 1 << 2;
        /// DSIO2 as an input.
        const DSI2 = 1 << 3;
    }
}
