//! The bootloader of the B-G431B-ESC1: verifies the image in the slot and enters it, if its owner has signed
//! it. It receives one over CAN when there is none, or when the drive has made way for it.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_rt::{entry, exception};
    use heapless::spsc::{Consumer, Queue};
    use narx_b_g431b_esc1::chip::fdcan::{self, ARRIVING, WAITING};
    use narx_b_g431b_esc1::chip::memory::Region;
    use narx_b_g431b_esc1::chip::{self, reset};
    use narx_b_g431b_esc1::flash_map::{HARDWARE, MAP, SIZE, START};
    use narx_boot::one_slot::Entry;
    use narx_boot::{OneSlot, Server, key};
    use narx_core::bus::Frame;
    use stm32_metapac::interrupt;

    #[entry]
    fn main() -> ! {
        static mut ARRIVING_FRAMES: Queue<Frame, WAITING> = Queue::new();

        // From reset on no output of TIM1 is on, and the gate drivers pull their inputs down.
        chip::start_for_boot();
        let Ok(mut slot) = OneSlot::new(Region::new(0..SIZE), MAP, HARDWARE) else { chip::stay() };
        match slot.boot(key::chosen()) {
            Ok(Entry::Run(_)) => reset::enter(START + MAP.entry()),
            Ok(Entry::Receive) => {
                let (arriving_in, arriving) = ARRIVING_FRAMES.split();
                ARRIVING.give(arriving_in);
                receive(slot, arriving)
            }
            Err(_) => chip::stay(),
        }
    }

    /// Receives an image, until the master has the chip restart.
    fn receive(mut slot: OneSlot<Region>, mut arriving: Consumer<'static, Frame>) -> ! {
        let Ok(mut loader) = slot.loader() else { chip::stay() };
        let mut server = Server::new(slot);
        let mut clock = chip::start_for_loading();
        while !loader.is_over() {
            let now = clock.milliseconds();
            while let Some(frame) = arriving.dequeue() {
                loader.handle_frame(&frame, now);
            }
            if let Some(task) = loader.poll_task(now) {
                loader.handle_reply(server.execute(&task), now);
            }
            if fdcan::room() > 0
                && let Some(frame) = loader.poll_frame()
            {
                fdcan::send(&frame);
            }
            // A controller that has gone bus-off is let back by this.
            let _ = fdcan::state();
            chip::show_loading(now);
            // Until the next frame or the next millisecond.
            cortex_m::asm::wfi();
        }
        reset::reset()
    }

    /// A millisecond is over.
    #[exception]
    fn SysTick() {}

    #[interrupt]
    fn FDCAN1_IT0() {
        fdcan::interrupt();
    }
}
