//! Counts what a drive in Standby does between two sleeps: `standby`, under `-icount shift=7`.
//!
//! Shell and device as on any board, with a bus on which a master asks for Standby every 50 ms, and samples
//! of a motor at rest. Prints `standby period PERIODS TOTAL WORST`: instructions from the control interrupt
//! to the background's WFI, both included. That there is a line at all says that every period ends asleep.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use core::sync::atomic::{AtomicU32, Ordering};
    use cortex_m::peripheral::SYST;
    use cortex_m::peripheral::syst::SystClkSource;
    use cortex_m_rt::{entry, exception};
    use cortex_m_semihosting::hprintln;
    use heapless::Deque;
    use narx_board::shell::{Background, Control, Progress};
    use narx_board::side::{BackgroundSide, TickSide};
    use narx_core::bus::narmotion::{FromDrive, MotorMode, RequestWord, ToDrive};
    use narx_core::bus::{BusState, Frame};
    use narx_core::device::Queues;
    use narx_core::dictionary::Parameters;
    use narx_core::motor::{Board, PwmCommand, Samples};
    use narx_core::node::{Identity, Node, Outputs, SlowInputs, update};
    use narx_firmware::boards::qemu::instructions::Sum;
    use narx_firmware::boards::qemu::{Owned, semihosting};

    /// Counts of the system timer a control tick: far more than its instructions take, 3.2 counts each.
    const PERIOD: u32 = 250_000;
    /// Standby begins after boot and the first request, control ticks; a second of it is counted.
    const BEGIN: u32 = 10_000;
    const END: u32 = BEGIN + 10_000;
    /// Ticks between two requests of the master.
    const REQUEST: u32 = 500;

    static CONTROL: Owned<Control<'static, 'static, Rest>> = Owned::nothing();
    static PROGRESS: Progress = Progress::new();
    /// Control ticks since power-up.
    static NOW: AtomicU32 = AtomicU32::new(0);

    #[entry]
    fn main() -> ! {
        static mut QUEUES: Queues<'static> = Queues::new();
        let Some(mut peripherals) = cortex_m::Peripherals::take() else { semihosting::exit(false) };
        let (tick, device) = QUEUES.power_up(Identity::default(), Board::BENCH, Parameters::new());
        CONTROL.give(Control::new(tick, Rest, &PROGRESS));
        let timer = &mut peripherals.SYST;
        timer.set_clock_source(SystClkSource::Core);
        timer.set_reload(PERIOD - 1);
        timer.clear_current();
        timer.enable_interrupt();
        timer.enable_counter();
        Background::new(device, Desk::default(), &PROGRESS).run()
    }

    #[exception]
    fn SysTick() {
        NOW.fetch_add(1, Ordering::Relaxed);
        CONTROL.with(Control::interrupt);
    }

    /// A motor at rest: 24 V, no current.
    struct Rest;

    impl TickSide for Rest {
        fn samples(&mut self) -> Option<Samples> {
            let tick = NOW.load(Ordering::Relaxed).into();
            Some(Samples { tick, bus_voltage: 1_229, bus_current: 2_048, hall: 0b101, ..Samples::default() })
        }

        fn apply(&mut self, _: &PwmCommand) {}
    }

    /// The background's side: a bus that takes everything, and a master on it.
    #[derive(Default)]
    struct Desk {
        arriving: Deque<Frame, 4>,
        awake: Sum,
        /// Mode in the last status of the drive.
        mode: Option<MotorMode>,
    }

    impl Desk {
        fn finish(&self) -> ! {
            hprintln!("# {:?}", self.mode);
            hprintln!("standby period {}", self.awake);
            semihosting::exit(self.mode == Some(MotorMode::Standby))
        }
    }

    impl BackgroundSide for Desk {
        fn now(&self) -> u64 {
            NOW.load(Ordering::Relaxed).into()
        }

        fn wait(&mut self) {
            let now = NOW.load(Ordering::Relaxed);
            let awake = PERIOD - SYST::get_current();
            if now >= BEGIN {
                self.awake.add((awake * 10 + 16) / 32);
            }
            if now >= END {
                self.finish();
            }
            if now.is_multiple_of(REQUEST) {
                let addresses = Node::new(Identity::default(), Board::BENCH).addresses();
                let standby = ToDrive::RequestWord(RequestWord { mode: MotorMode::Standby });
                let speed = ToDrive::MotorCommand { speed: 0 };
                // There is room: they were taken in the pass before.
                let _ = self.arriving.push_back(standby.encode(addresses));
                let _ = self.arriving.push_back(speed.encode(addresses));
            }
            cortex_m::asm::wfi();
        }

        fn receive(&mut self) -> Option<Frame> {
            self.arriving.pop_front()
        }

        fn is_ready_to_send(&self) -> bool {
            true
        }

        fn is_ready_for_bulk(&self) -> bool {
            true
        }

        fn send(&mut self, frame: &Frame) {
            if let Ok((_, FromDrive::Status(status))) = FromDrive::decode(frame) {
                self.mode = Some(status.mode);
            }
        }

        fn bus_state(&self) -> BusState {
            BusState::default()
        }

        fn discard_frames(&mut self) {}

        fn slow_inputs(&mut self) -> SlowInputs {
            SlowInputs::default()
        }

        fn apply(&mut self, _: Outputs) {}

        fn serve_update(&mut self, _: &update::SlotTask) -> update::SlotReply {
            update::SlotReply::Done
        }

        fn feed_watchdog(&mut self) {}

        fn reboot(&mut self) {}
    }
}
