//! Both sides of the board, as `narx_board` has them: the control interrupt's and the node's task's.

use crate::board::{
    CURRENT_ZERO, SHUNT_ZERO, SHUNT_ZERO_TOLERANCE, SKEW, bus_current, temperature, terminal,
};
use crate::bridge::{self, BRIDGE, Bridge};
use crate::converter::{self, Codes};
use crate::frames::{self, ARRIVING, LEAVING};
use crate::pins;
use core::cell::Cell;
use critical_section::Mutex;
use embassy_stm32::can::Properties;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;
use narx_board::side::{BackgroundSide, TickSide};
use narx_board::stm32::Gates;
use narx_core::bus::{BusState, Frame};
use narx_core::motor::{CurrentMode, Lines, PwmCommand, SampleMode, Samples};
use narx_core::node::{Outputs, SlowInputs};
use narx_core::units::Duty;

/// Control ticks since power-up, for the background.
static NOW: Mutex<Cell<u64>> = Mutex::new(Cell::new(0));

/// Ticks over which the shunts' zeros are averaged before any output is on.
const ZERO_TICKS: u16 = 1 << ZERO_SHIFT;
const ZERO_SHIFT: u32 = 10;

/// The control interrupt's side.
#[derive(Debug, Default)]
pub struct Tick {
    number: u64,
    /// Count of TIM2 at the boundary of this period.
    start: u32,
    /// Duty that the last command has put in force.
    duty: Duty,
    mode: SampleMode,
    /// Sums of the shunts' codes without current, and of how many ticks.
    zeros: [u32; 3],
    zero_ticks: u16,
}

impl Tick {
    const fn zeros_are_known(&self) -> bool {
        self.zero_ticks == ZERO_TICKS
    }

    /// Returns whether shunts and amplifiers can be intact.
    fn zeros_are_credible(&self) -> bool {
        let near =
            |sum: u32| (sum >> ZERO_SHIFT).abs_diff(SHUNT_ZERO.into()) <= u32::from(SHUNT_ZERO_TOLERANCE);
        self.zeros.into_iter().all(near)
    }

    fn current(&mut self, codes: &Codes, gates: [Gates; 3]) -> u16 {
        if self.zeros_are_known() {
            let mut above = codes.shunts.map(i32::from);
            above.iter_mut().zip(self.zeros).for_each(|(code, sum)| *code -= (sum >> ZERO_SHIFT) as i32);
            return bus_current(above, gates, self.duty, self.mode);
        }
        self.zeros.iter_mut().zip(codes.shunts).for_each(|(sum, code)| *sum += u32::from(code));
        self.zero_ticks += 1;
        if self.zeros_are_known() && self.zeros_are_credible() {
            BRIDGE.with(Bridge::arm);
        }
        CURRENT_ZERO
    }
}

impl TickSide for Tick {
    fn samples(&mut self) -> Option<Samples> {
        let codes = converter::take()?;
        self.start = bridge::boundary();
        let (mut gates, mut broken) = ([Gates::Off; 3], false);
        BRIDGE.with(|bridge| (gates, broken) = (bridge.gates(), bridge.is_broken()));
        if broken {
            gates = [Gates::Off; 3];
        }
        let [a, b, c] = codes.terminals;
        let mut lines = Lines::empty();
        lines.set(Lines::EMERGENCY, broken);
        let bus_current = self.current(&codes, gates);
        // Without currents nothing is driven.
        lines.set(Lines::DRIVER_FAULT, self.zeros_are_known() && !self.zeros_are_credible());
        let samples = Samples {
            tick: self.number,
            bus_voltage: codes.bus,
            phase_voltage: [
                terminal(a, gates[0], self.mode, codes.bus),
                terminal(b, gates[1], self.mode, codes.bus),
                terminal(c, gates[2], self.mode, codes.bus),
            ],
            bus_current,
            sample_mode: self.mode,
            current_mode: CurrentMode::Average,
            skew: SKEW,
            hall: pins::halls(),
            lines,
            ..Samples::default()
        };
        self.number += 1;
        critical_section::with(|section| NOW.borrow(section).set(self.number));
        Some(samples)
    }

    fn apply(&mut self, command: &PwmCommand) {
        (self.duty, self.mode) = (command.duty, command.sample_mode);
        BRIDGE.with(|bridge| bridge.apply(command, self.start));
    }
}

/// The node's side.
pub struct Node {
    /// The controller's state.
    pub bus: Properties,
    /// Resets when it is not fed.
    pub watchdog: IndependentWatchdog<'static, IWDG>,
}

impl BackgroundSide for Node {
    fn now(&self) -> u64 {
        critical_section::with(|section| NOW.borrow(section).get())
    }

    /// Nothing: the task itself waits between two passes.
    fn wait(&mut self) {}

    fn receive(&mut self) -> Option<Frame> {
        ARRIVING.try_receive().ok()
    }

    fn is_ready_to_send(&self) -> bool {
        !LEAVING.is_full()
    }

    fn is_ready_for_bulk(&self) -> bool {
        LEAVING.is_empty()
    }

    fn send(&mut self, frame: &Frame) {
        let _ = LEAVING.try_send(*frame);
    }

    fn bus_state(&self) -> BusState {
        frames::state(&self.bus)
    }

    fn discard_frames(&mut self) {
        LEAVING.clear();
    }

    fn slow_inputs(&mut self) -> SlowInputs {
        SlowInputs { ambient_temperature: temperature(converter::temperature()), ..SlowInputs::default() }
    }

    fn apply(&mut self, _: Outputs) {}

    fn feed_watchdog(&mut self) {
        self.watchdog.pet();
    }

    fn reboot(&mut self) {
        cortex_m::peripheral::SCB::sys_reset()
    }
}
