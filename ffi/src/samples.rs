//! Inputs of the control tick.

use crate::status::narx_status_t::{self, *};
use heapless::Vec;
use narx_core::motor::sense::samples::EDGES_MAX;
use narx_core::motor::{CurrentMode, Edge, EdgeSource, Lines, SampleMode, Samples};

/// Largest number of edges in one period; more are counted in narx_samples_t.edges_lost.
pub const NARX_EDGES_MAX: usize = 4;

/// Bit of narx_samples_t.lines: the gate driver reports a fault.
pub const NARX_LINE_DRIVER_FAULT: u8 = 1;
/// Bit of narx_samples_t.lines: the hardware break input has tripped.
pub const NARX_LINE_EMERGENCY: u8 = 2;
/// Bit of narx_samples_t.lines: DSIO1 as an input.
pub const NARX_LINE_DSI1: u8 = 4;
/// Bit of narx_samples_t.lines: DSIO2 as an input.
pub const NARX_LINE_DSI2: u8 = 8;

const _: () = assert!(
    NARX_EDGES_MAX == EDGES_MAX
        && NARX_LINE_DRIVER_FAULT == Lines::DRIVER_FAULT.bits()
        && NARX_LINE_EMERGENCY == Lines::EMERGENCY.bits()
        && NARX_LINE_DSI1 == Lines::DSI1.bits()
        && NARX_LINE_DSI2 == Lines::DSI2.bits(),
    "the header has these constants as plain numbers: set them to the core's"
);

/// One time-stamped edge.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_edge_t {
    /// Instant, in 1/65 536 of the period that has just ended.
    pub instant: u16,
    /// Source of the edge: a narx_edge_source_t.
    pub source: u8,
    /// The three lines after the edge: bit 0 = A, bit 1 = B, bit 2 = C.
    pub code: u8,
}

/// All inputs of the tick `tick`, measured in period `tick` at the instant that the previous command
/// requested.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_samples_t {
    /// Number of this PWM period since power-up.
    pub tick: u64,
    /// Terminal voltages of phases A, B, C against ground, converter codes.
    pub phase_voltage: [u16; 3],
    /// Bus voltage, converter code.
    pub bus_voltage: u16,
    /// Bus current, converter code; see current_mode.
    pub bus_current: u16,
    /// Time from the bus voltage's conversion to phase C's, in 1/65 536 of a period (A and B lie evenly
    /// between).
    pub skew: u16,
    /// Part of the period in which the phase voltages were sampled: a narx_sample_mode_t.
    pub sample_mode: u8,
    /// Kind of bus_current: a narx_current_mode_t. The drive ignores it and takes every reading for
    /// NARX_CURRENT_MODE_AVERAGE.
    pub current_mode: u8,
    /// Hall lines at the sampling instant: bit 0 = A, bit 1 = B, bit 2 = C.
    pub hall: u8,
    /// Digital inputs at the sampling instant: sum of NARX_LINE_*, a bit is set while the input is asserted.
    pub lines: u8,
    /// Number of valid `edges`.
    pub edge_count: u8,
    /// Number of edges of period `tick` - 1 beyond NARX_EDGES_MAX.
    pub edges_lost: u8,
    /// Edges captured during the whole of period `tick` - 1, oldest first.
    pub edges: [narx_edge_t; NARX_EDGES_MAX],
}

impl narx_samples_t {
    /// Converts these samples into `to`, which must be empty. A result with the samples in it would be copied
    /// once more, in every control tick.
    pub(crate) fn convert(&self, to: &mut Samples) -> Result<(), narx_status_t> {
        to.tick = self.tick;
        to.phase_voltage = self.phase_voltage;
        to.bus_voltage = self.bus_voltage;
        to.bus_current = self.bus_current;
        to.sample_mode = one_of([SampleMode::OffTime, SampleMode::OnTime], self.sample_mode)?;
        to.current_mode = one_of([CurrentMode::Average, CurrentMode::OnTime], self.current_mode)?;
        to.skew = self.skew;
        to.hall = self.hall;
        to.edges_lost = self.edges_lost;
        to.lines = Lines::from_bits_retain(self.lines);
        convert_edges(self.edges.get(..self.edge_count.into()).ok_or(NARX_ERROR_SAMPLES)?, &mut to.edges)
    }
}

impl From<&Samples> for narx_samples_t {
    fn from(samples: &Samples) -> Self {
        let mut edges = [narx_edge_t { instant: 0, source: 0, code: 0 }; NARX_EDGES_MAX];
        for (to, Edge { instant, source, code }) in edges.iter_mut().zip(&samples.edges) {
            *to = narx_edge_t { instant: *instant, source: *source as u8, code: *code };
        }
        Self {
            tick: samples.tick,
            phase_voltage: samples.phase_voltage,
            bus_voltage: samples.bus_voltage,
            bus_current: samples.bus_current,
            skew: samples.skew,
            sample_mode: samples.sample_mode as u8,
            current_mode: samples.current_mode as u8,
            hall: samples.hall,
            lines: samples.lines.bits(),
            edge_count: samples.edges.len() as u8,
            edges_lost: samples.edges_lost,
            edges,
        }
    }
}

/// Converts at most [`NARX_EDGES_MAX`] edges into `to`, which must be empty.
pub(crate) fn convert_edges(
    edges: &[narx_edge_t],
    to: &mut Vec<Edge, EDGES_MAX>,
) -> Result<(), narx_status_t> {
    for edge in edges {
        let source = one_of([EdgeSource::Hall, EdgeSource::Comparator], edge.source)?;
        let edge = Edge { instant: edge.instant, source, code: edge.code };
        to.push(edge).map_err(|_| NARX_ERROR_SAMPLES)?;
    }
    Ok(())
}

/// Returns the value of an enumeration with this number; `values` are in the order of their numbers.
fn one_of<T: Copy>(values: [T; 2], number: u8) -> Result<T, narx_status_t> {
    values.get(usize::from(number)).copied().ok_or(NARX_ERROR_SAMPLES)
}
