//! The control interrupt's side of the board.

use super::converter::{self, Codes};
use super::power_stage::{BRIDGE, since_boundary};
use super::{capture, ports};
use crate::analog::{CURRENT_ZERO, SHUNT_ZERO, SHUNT_ZERO_TOLERANCE, bus_current, terminal};
use crate::edges::Edges;
use core::cell::Cell;
use critical_section::Mutex;
use narx_board::side::TickSide;
use narx_board::stm32::Gates;
use narx_core::motor::{CurrentMode, Lines, PwmCommand, SampleMode, Samples};
use narx_core::units::Duty;

/// Control ticks since power-up, for the background.
static NOW: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// Control ticks since power-up.
pub(super) fn now() -> u64 {
    critical_section::with(|section| NOW.borrow(section).get())
}

/// Ticks over which the zeros of the shunts are averaged before any output is on: 0.1 s, a fifth of
/// Initialization.
const ZERO_TICKS: u16 = 1 << ZERO_SHIFT;
const ZERO_SHIFT: u32 = 10;

/// State that the control interrupt owns.
#[derive(Debug, Default)]
pub struct Tick {
    number: u64,
    /// Count of TIM4 at the boundary of the present period.
    start: u16,
    edges: Edges,
    /// Duty that the last command has put in force.
    duty: Duty,
    mode: SampleMode,
    zeros: Zeros,
    /// Which slow channel is converted.
    turn: u8,
}

/// The shunts' codes without current.
#[derive(Clone, Copy, Debug, Default)]
struct Zeros {
    sums: [u32; 3],
    ticks: u16,
}

impl Zeros {
    /// Adds a tick; true with the last one.
    fn find(&mut self, shunts: [u16; 3]) -> bool {
        for (sum, code) in self.sums.iter_mut().zip(shunts) {
            *sum += u32::from(code);
        }
        self.ticks += 1;
        self.ticks == ZERO_TICKS
    }

    const fn are_known(&self) -> bool {
        self.ticks == ZERO_TICKS
    }

    fn codes(&self) -> [i32; 3] {
        self.sums.map(|sum| (sum >> ZERO_SHIFT) as i32)
    }

    /// Returns whether all zeros are within the tolerance, so that shunts and amplifiers can be intact.
    fn are_credible(&self) -> bool {
        let near = |code: i32| code.abs_diff(SHUNT_ZERO.into()) <= u32::from(SHUNT_ZERO_TOLERANCE);
        self.codes().into_iter().all(near)
    }
}

impl Tick {
    fn current(&mut self, codes: &Codes, gates: [Gates; 3]) -> u16 {
        if !self.zeros.are_known() {
            if self.zeros.find(codes.shunts) && self.zeros.are_credible() {
                BRIDGE.with(super::power_stage::Bridge::arm);
            }
            return CURRENT_ZERO;
        }
        let mut above = codes.shunts.map(i32::from);
        above.iter_mut().zip(self.zeros.codes()).for_each(|(code, zero)| *code -= zero);
        bus_current(above, gates, self.duty, self.mode)
    }

    fn lines(&self, broken: bool) -> Lines {
        let [dsi1, dsi2] = ports::digital();
        let mut lines = Lines::empty();
        lines.set(Lines::DSI1, dsi1);
        lines.set(Lines::DSI2, dsi2);
        lines.set(Lines::EMERGENCY, broken);
        // Without currents nothing is driven.
        lines.set(Lines::DRIVER_FAULT, self.zeros.are_known() && !self.zeros.are_credible());
        lines
    }
}

impl TickSide for Tick {
    fn samples(&mut self) -> Option<Samples> {
        let codes = converter::take()?;
        converter::go_on(&mut self.turn);
        self.start = capture::now().wrapping_sub(since_boundary());
        let (mut gates, mut broken) = ([Gates::Off; 3], false);
        BRIDGE.with(|bridge| (gates, broken) = (bridge.gates(), bridge.is_broken()));
        if broken {
            gates = [Gates::Off; 3];
        }
        let mut samples = Samples {
            tick: self.number,
            bus_voltage: codes.bus,
            phase_voltage: [
                terminal(codes.terminals[0], gates[0], self.mode, codes.bus),
                terminal(codes.terminals[1], gates[1], self.mode, codes.bus),
                terminal(codes.terminals[2], gates[2], self.mode, codes.bus),
            ],
            bus_current: self.current(&codes, gates),
            sample_mode: self.mode,
            current_mode: CurrentMode::Average,
            skew: crate::SKEW,
            hall: ports::hall(),
            lines: self.lines(broken),
            ..Samples::default()
        };
        samples.edges_lost = capture::take(&mut self.edges);
        self.edges.take(self.start, &mut samples);
        self.number += 1;
        critical_section::with(|section| NOW.borrow(section).set(self.number));
        Some(samples)
    }

    fn apply(&mut self, command: &PwmCommand) {
        (self.duty, self.mode) = (command.duty, command.sample_mode);
        BRIDGE.with(|bridge| bridge.apply(command, self.start));
    }
}
