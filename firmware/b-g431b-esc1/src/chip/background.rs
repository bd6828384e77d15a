//! The background's side of the board.

use super::memory::Region;
use super::self_test::Tests;
use super::{converter, fdcan, ports, reset, tick, watchdog};
use crate::analog::{pin, reference_tap, temperature};
use heapless::spsc::Consumer;
use narx_board::side::BackgroundSide;
use narx_boot::{Inside, Server};
use narx_core::bus::{BusState, Frame};
use narx_core::node::update::{SlotReply, SlotTask};
use narx_core::node::{Outputs, ResetCause, SelfTests, SlowInputs};
use stm32_metapac::VREFINTCAL;

/// State that the background owns.
pub struct Loop {
    /// From the interrupt.
    pub arriving: Consumer<'static, Frame>,
    /// Cause of the chip's last reset.
    pub cause: ResetCause,
    /// Tests that go on; without any nothing fails.
    pub tests: Option<Tests>,
    /// Makes way for the bootloader.
    pub server: Server<Inside<Region>>,
    /// Time at which the LED changes next, ticks.
    pub blink_due: u64,
}

/// Time between two changes of the LED, ticks: half a second, after a reset by the watchdog a tenth, until
/// power-up or REBOOT.
const BLINK: u64 = 5_000;
const BLINK_AFTER_WATCHDOG: u64 = 1_000;
/// Time that a reboot waits for the last frames, ticks: 10 ms.
const LAST_FRAMES: u64 = 100;

impl BackgroundSide for Loop {
    fn now(&self) -> u64 {
        tick::now()
    }

    fn wait(&mut self) {
        // The control interrupt ends it every 100 us at the latest.
        cortex_m::asm::wfi();
    }

    fn receive(&mut self) -> Option<Frame> {
        self.arriving.dequeue()
    }

    fn is_ready_to_send(&self) -> bool {
        fdcan::room() > 0
    }

    fn is_ready_for_bulk(&self) -> bool {
        fdcan::has_room_for_bulk()
    }

    fn send(&mut self, frame: &Frame) {
        fdcan::send(frame);
    }

    fn bus_state(&self) -> BusState {
        fdcan::state()
    }

    fn discard_frames(&mut self) {
        fdcan::discard();
    }

    fn slow_inputs(&mut self) -> SlowInputs {
        let [thermistor, potentiometer, reference] = converter::slow();
        let [dsi1, dsi2] = ports::digital();
        // What the board does not have reads 0: a second thermistor, pressure, accelerometer, rails.
        SlowInputs {
            ambient_temperature: temperature(thermistor),
            asi: pin(potentiometer),
            reference: reference_tap(reference, VREFINTCAL.data().read()),
            dsi1,
            dsi2,
            ..SlowInputs::default()
        }
    }

    /// Nothing to set: both lines are inputs, and the hall sensors' supply has no switch.
    fn apply(&mut self, _: Outputs) {}

    fn self_test(&mut self) -> SelfTests {
        let ticks = self.now();
        self.tests.as_mut().map_or(SelfTests::empty(), |tests| tests.step(ticks))
    }

    fn serve_update(&mut self, request: &SlotTask) -> SlotReply {
        self.server.execute(request)
    }

    fn feed_watchdog(&mut self) {
        watchdog::feed();
        if self.now() >= self.blink_due {
            let after_watchdog = self.cause == ResetCause::Watchdog;
            self.blink_due = self.now() + if after_watchdog { BLINK_AFTER_WATCHDOG } else { BLINK };
            ports::toggle_led();
        }
    }

    fn reboot(&mut self) {
        let until = self.now() + LAST_FRAMES;
        while !fdcan::is_idle() && self.now() < until {}
        reset::reset()
    }
}
