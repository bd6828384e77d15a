//! The board without the drive: start-up, vector table, drivers, shell and both ends of the flash around a
//! core that answers every tick with Coast. What it takes is what the board takes beside the core.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_rt::entry;
    use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
    use heapless::spsc::Queue;
    use narx_b_g431b_esc1::chip::background::Loop;
    use narx_b_g431b_esc1::chip::fdcan::{self, ARRIVING, WAITING};
    use narx_b_g431b_esc1::chip::memory::Region;
    use narx_b_g431b_esc1::chip::power_stage::{BRIDGE, Bridge};
    use narx_b_g431b_esc1::chip::tick::Tick;
    use narx_b_g431b_esc1::chip::{self, reset};
    use narx_b_g431b_esc1::flash_map::{HARDWARE, MAP, SIZE};
    use narx_board::owned::Owned;
    use narx_board::side::{BackgroundSide, TickSide};
    use narx_boot::{Inside, OneSlot, Server};
    use narx_core::bus::Frame;
    use narx_core::motor::PwmCommand;
    use stm32_metapac::interrupt;

    /// The control interrupt's.
    static TICK: Owned<Tick> = Owned::nothing();

    #[entry]
    fn main() -> ! {
        static mut ARRIVING_FRAMES: Queue<Frame, WAITING> = Queue::new();

        let cause = reset::cause();
        chip::start();
        let Some(mut core) = cortex_m::Peripherals::take() else { reset::fail() };
        let (arriving_in, arriving) = ARRIVING_FRAMES.split();
        ARRIVING.give(arriving_in);
        BRIDGE.give(Bridge::default());
        TICK.give(Tick::default());
        chip::listen(&mut core.NVIC);
        let Ok(slot) = OneSlot::new(Region::new(0..SIZE), MAP, HARDWARE) else { reset::fail() };
        let mut parameters = Region::new(MAP.parameters);
        let mut side = Loop {
            arriving,
            cause,
            tests: None,
            server: Server::new(Inside { slot, addresses: [0, 0] }),
            blink_due: 0,
        };
        loop {
            side.wait();
            let mut page = [0; 8];
            let stored = parameters.read(0, &mut page).is_ok() && parameters.erase(0, 2048).is_ok();
            let _ = stored && parameters.write(0, &page).is_ok();
            if side.bus_state().is_off() {
                side.discard_frames();
            }
            if let Some(frame) = side.receive()
                && side.is_ready_to_send()
                && side.is_ready_for_bulk()
            {
                side.send(&frame);
            }
            if side.slow_inputs().dsi2 {
                side.reboot();
            }
            side.feed_watchdog();
        }
    }

    #[interrupt]
    fn ADC1_2() {
        TICK.with(|tick| {
            if let Some(samples) = tick.samples() {
                let sample_at = samples.bus_voltage;
                tick.apply(&PwmCommand { sample_at, ..PwmCommand::default() });
            }
        });
    }

    #[interrupt]
    fn TIM4() {
        BRIDGE.with(Bridge::commutate);
    }

    #[interrupt]
    fn FDCAN1_IT0() {
        fdcan::interrupt();
    }
}
