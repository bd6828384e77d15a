//! The two sides of the board: a simulated motor and power stage, and an slcan adapter on the serial port.

use super::pace::Pace;
use super::slots::Slots;
use super::trouble::{Task, Trouble};
use super::uart::Uart;
use super::watchdog::Watchdog;
use super::{kept, pace, program, semihosting, stack};
use crate::boards::cortex_m as image;
use cortex_m::peripheral::SCB;
use heapless::spsc::{Consumer, Producer};
use narx_board::self_test::clock::{TickMonitor, Tolerance};
use narx_board::self_test::walk::Walk;
use narx_board::side::{BackgroundSide, TickSide};
use narx_boot::{Server, Slot};
use narx_core::bus::narmotion::update::UpdateCode;
use narx_core::bus::slcan::{Adapter, LINE_MAX};
use narx_core::bus::{BusState, Frame};
use narx_core::motor::{PwmCommand, Samples};
use narx_core::node::update;
use narx_core::node::{Outputs, ResetCause, SelfTests, SlowInputs};
use narx_core::queue::{dequeue, enqueue};
use narx_sim::plant::Plant;

/// Bit rate of the drive's bus, bit/s (Table 2). An adapter set to another receives and says nothing.
const BITRATE: u32 = 500_000;
/// Bits of a frame with a 29-bit identifier and 8 bytes, at least.
const FRAME_BITS: u64 = 131;
/// The walk over the program takes this much at a time: a second for the whole image.
const WALK_BYTES: usize = 4096;
/// The stack is looked at this often, ticks.
const STACK_TICKS: u64 = 10_000;

/// The interrupt's side: samples that the plant has left, and a command for it.
pub struct Period {
    /// From the plant.
    pub samples: Consumer<'static, Samples>,
    /// To the plant.
    pub commands: Producer<'static, PwmCommand>,
    /// Trouble on order.
    pub trouble: Option<Trouble>,
}

impl TickSide for Period {
    fn samples(&mut self) -> Option<Samples> {
        let samples = dequeue(&mut self.samples)?;
        if let Some(trouble) = self.trouble {
            trouble.meet(Task::Control, samples.tick);
        }
        Some(samples)
    }

    fn apply(&mut self, command: &PwmCommand) {
        // The plant has taken the one before, or it would not have sampled again.
        let _ = enqueue(&mut self.commands, *command);
    }
}

/// The background's side: it runs the world, and pends the control interrupt when a period was sampled.
pub struct World {
    /// Motor, power stage, supply and sensors.
    pub plant: Plant,
    /// To the interrupt.
    pub samples: Producer<'static, Samples>,
    /// From the interrupt.
    pub commands: Consumer<'static, PwmCommand>,
    /// Line to the host.
    pub uart: Uart,
    /// Adapter that speaks on the line.
    pub adapter: Adapter,
    /// Holds time back.
    pub pace: Pace,
    /// Resets the machine when it is not fed.
    pub watchdog: Watchdog,
    /// Control ticks a second.
    pub tick_rate: u16,
    /// Most of the stack that was seen used, bytes.
    pub stack: usize,
    /// Time at which a real bus would have taken all frames sent so far, ticks: the serial line is faster
    /// than a bus.
    pub bus_free_at: u64,
    /// Tests that go on.
    pub tests: Tests,
    /// Trouble on order.
    pub trouble: Option<Trouble>,
    /// Writes the slots, where there is a bootloader that looks at them.
    pub server: Option<Server<Slot<Slots>>>,
}

/// Self-tests of this board. It has no second clock: all clocks in the emulator count the same time, so there
/// is no test of clocks at boot; and as a busy host may slow the motor down, control ticks are watched for
/// being too fast only.
pub struct Tests {
    failed: SelfTests,
    walk: Walk,
    monitor: TickMonitor,
}

impl Tests {
    /// At boot; `is_ram_sound` was found as early as possible. `tick_rate`: control ticks a second.
    pub fn boot(is_ram_sound: bool, tick_rate: u16) -> Self {
        const TOLERANCE: Tolerance = Tolerance { slow: 1000, fast: 20 };
        Self {
            failed: if is_ram_sound { SelfTests::empty() } else { SelfTests::RAM },
            walk: Walk::new(image::program()),
            monitor: TickMonitor::new(tick_rate, 1000, TOLERANCE, 1000, pace::milliseconds()),
        }
    }

    fn step(&mut self, ticks: u64) -> SelfTests {
        self.failed.set(
            SelfTests::STACK,
            self.failed.contains(SelfTests::STACK) || !image::is_stack_end_untouched(),
        );
        self.failed.set(SelfTests::FLASH, !self.walk.step(image::program(), WALK_BYTES));
        self.failed.set(SelfTests::TICK, !self.monitor.step(ticks, pace::milliseconds()));
        self.failed
    }
}

impl World {
    fn note_stack(&mut self) {
        let used = stack::high_water();
        if used > self.stack {
            self.stack = used;
            semihosting::print_line(format_args!("stack: {used} bytes used at most"));
        }
    }

    fn meet(&self, task: Task) {
        if let Some(trouble) = self.trouble {
            trouble.meet(task, self.plant.tick());
        }
    }

    fn is_on_bus(&self) -> bool {
        self.adapter.bitrate() == BITRATE
    }
}

impl BackgroundSide for World {
    fn now(&self) -> u64 {
        self.plant.tick()
    }

    fn wait(&mut self) {
        // There is room: the interrupt takes samples as soon as they are there.
        let _ = enqueue(&mut self.samples, self.plant.sample());
        if !self.trouble.is_some_and(|trouble| trouble.has(Task::NoControl, self.plant.tick())) {
            SCB::set_pendsv();
        }
        // The interrupt strikes here.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        let command = dequeue(&mut self.commands).unwrap_or_default();
        self.plant.finish_period(&command);
        self.uart.pump();
        let tick = self.plant.tick();
        super::flash::set_now(tick);
        if tick.is_multiple_of(STACK_TICKS) {
            self.note_stack();
        }
        self.pace.wait_for(tick);
    }

    fn receive(&mut self) -> Option<Frame> {
        self.meet(Task::Can);
        while let Some(byte) = self.uart.read() {
            let Some(answer) = self.adapter.handle_byte(byte) else { continue };
            kept::keep(self.adapter.settings());
            // A host that reads nothing for thousands of bytes misses replies, too.
            self.uart.write(&answer.reply);
            if let Some(frame) = answer.frame.filter(|_| self.is_on_bus()) {
                return Some(frame);
            }
        }
        None
    }

    fn is_ready_to_send(&self) -> bool {
        self.uart.room() >= LINE_MAX
    }

    fn is_ready_for_bulk(&self) -> bool {
        self.is_ready_to_send() && self.now() >= self.bus_free_at
    }

    fn send(&mut self, frame: &Frame) {
        let tick_rate = u64::from(self.tick_rate);
        let ticks = (FRAME_BITS * tick_rate).div_ceil(BITRATE.into());
        self.bus_free_at = self.bus_free_at.max(self.now()) + ticks;
        let line = self.adapter.handle_frame(frame, self.now() * 1000 / tick_rate.max(1));
        if let Some(line) = line.filter(|_| self.is_on_bus())
            && !self.uart.write(&line)
        {
            self.adapter.note_lost();
        }
    }

    fn bus_state(&self) -> BusState {
        // The adapter has a bus of its own, and a serial line has no errors.
        BusState::default()
    }

    fn discard_frames(&mut self) {}

    fn slow_inputs(&mut self) -> SlowInputs {
        self.meet(Task::Background);
        self.plant.slow_inputs()
    }

    fn apply(&mut self, outputs: Outputs) {
        self.plant.set_outputs(outputs);
    }

    fn self_test(&mut self) -> SelfTests {
        let tick = self.plant.tick();
        if self
            .trouble
            .is_some_and(|trouble| trouble.after.abs_diff(tick) < 50 && trouble.has(Task::Program, tick))
        {
            program::spoil();
        }
        if self.trouble.is_some_and(|trouble| trouble.has(Task::Stack, tick)) {
            stack::spoil();
        }
        self.tests.step(self.plant.tick())
    }

    fn serve_update(&mut self, request: &update::SlotTask) -> update::SlotReply {
        match &mut self.server {
            Some(server) => server.execute(request),
            None => update::SlotReply::Failed(UpdateCode::Flash),
        }
    }

    fn feed_watchdog(&mut self) {
        self.watchdog.feed();
    }

    fn reboot(&mut self) {
        // The acknowledgement leaves first.
        while self.uart.pump() {}
        kept::note_cause(ResetCause::Requested);
        SCB::sys_reset();
    }
}
