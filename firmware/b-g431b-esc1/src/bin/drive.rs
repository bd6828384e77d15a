//! The drive on the B-G431B-ESC1, behind its bootloader, with everything that the board has use for.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use cortex_m_rt::entry;
    use heapless::spsc::{Consumer, Queue};
    use narx_b_g431b_esc1::BOARD;
    use narx_b_g431b_esc1::chip::background::Loop;
    use narx_b_g431b_esc1::chip::fdcan::{self, ARRIVING, WAITING};
    use narx_b_g431b_esc1::chip::memory::Region;
    use narx_b_g431b_esc1::chip::power_stage::{BRIDGE, Bridge};
    use narx_b_g431b_esc1::chip::self_test::Tests;
    use narx_b_g431b_esc1::chip::tick::Tick;
    use narx_b_g431b_esc1::chip::{self, reset};
    use narx_b_g431b_esc1::flash_map::{HARDWARE, MAP, SIZE};
    use narx_board::owned::Owned;
    use narx_board::shell::{Background, Control, Progress};
    use narx_boot::{Inside, OneSlot, Server};
    use narx_core::bus::Frame;
    use narx_core::device::{self, ControlTick, Queues};
    use narx_core::dictionary::{Parameters, number};
    use narx_core::node::{Identity, ResetCause};
    use narx_core::scope::Memory;
    use narx_core::storage::{CodeFlash, FlashReply, FlashTask, Mailbox, Opened};
    use static_cell::StaticCell;
    use stm32_metapac::interrupt;

    /// The control interrupt's.
    static CONTROL: Owned<&'static mut Control<'static, 'static, Tick>> = Owned::nothing();
    static PROGRESS: Progress = Progress::new();

    // Cells that are filled at start-up: as variables with a value they would stand in the flash a second
    // time.
    static CONTROL_PLACE: StaticCell<Control<'static, 'static, Tick>> = StaticCell::new();
    static MAILBOX: StaticCell<Mailbox> = StaticCell::new();
    static SCOPE: StaticCell<Memory<[u16; SCOPE_WORDS]>> = StaticCell::new();
    static BACKGROUND: StaticCell<Background<'static, 'static, Loop>> = StaticCell::new();
    static STORAGE: StaticCell<CodeFlash<Region>> = StaticCell::new();

    /// Words of the scope: 4 KiB. The stack needs the rest of the RAM.
    const SCOPE_WORDS: usize = 2048;

    #[entry]
    fn main() -> ! {
        static mut QUEUES: Queues<'static> = Queues::new();
        static mut ARRIVING_FRAMES: Queue<Frame, WAITING> = Queue::new();

        let cause = reset::cause();
        chip::start();
        let tests = Tests::boot();
        let Some(mut core) = cortex_m::Peripherals::take() else { reset::fail() };
        let (storage, scope) = (storage(), scope());
        let (arriving_in, arriving) = ARRIVING_FRAMES.split();
        ARRIVING.give(arriving_in);
        BRIDGE.give(Bridge::default());
        let mailbox: &'static Mailbox = MAILBOX.init_with(Mailbox::new);
        let opened = open(storage);
        let background = power_up(QUEUES, scope, arriving, cause, tests, &opened);
        background.attach_flash(mailbox, &opened);
        chip::listen(&mut core.NVIC);
        loop {
            background.pass();
            mailbox.serve_step(storage);
        }
    }

    // Each of the large values is made out of line and has its place: together in `main`, they and their
    // copies would take more stack than there is.

    #[inline(never)]
    fn storage() -> &'static mut CodeFlash<Region> {
        STORAGE.init_with(|| CodeFlash::new(Region::new(MAP.parameters)))
    }

    #[inline(never)]
    fn scope() -> &'static mut Memory<[u16; SCOPE_WORDS]> {
        SCOPE.init_with(Memory::new)
    }

    /// Makes the device, gives the control interrupt its half, and returns the background with the other one.
    #[inline(never)]
    fn power_up(
        queues: &'static mut Queues<'static>,
        scope: &'static mut Memory<[u16; SCOPE_WORDS]>,
        arriving: Consumer<'static, Frame>,
        cause: ResetCause,
        tests: Tests,
        opened: &Opened,
    ) -> &'static mut Background<'static, 'static, Loop> {
        // As one value, because two would be copies of it.
        let mut halves = queues.power_up(IDENTITY, BOARD, opened.parameters.clone());
        place_tick(halves.0);
        let device = &mut halves.1;
        device.attach_scope(scope);
        device.node().store_at_rest_only();
        device.node().handle_reset_cause(cause);
        let server = serve(device, opened);
        place_background(halves.1, Loop { arriving, cause, tests: Some(tests), server, blink_due: 0 })
    }

    #[inline(never)]
    fn place_tick(tick: ControlTick<'static, 'static>) {
        CONTROL.give(CONTROL_PLACE.init_with(|| Control::new(tick, Tick::default(), &PROGRESS)));
    }

    #[inline(never)]
    fn place_background(
        device: device::Background<'static, 'static>,
        board: Loop,
    ) -> &'static mut Background<'static, 'static, Loop> {
        BACKGROUND.init_with(|| Background::new(device, board, &PROGRESS))
    }

    /// The end of the slot that serves a master who programs the drive.
    #[inline(never)]
    fn serve(device: &mut device::Background<'static, 'static>, opened: &Opened) -> Server<Inside<Region>> {
        let Ok(slot) = OneSlot::new(Region::new(0..SIZE), MAP, HARDWARE) else { reset::fail() };
        let addresses = [number::SLAVE_CAN_ADDRESS, number::MASTER_CAN_ADDRESS];
        let addresses = addresses.map(|number| opened.parameters.raw(number) as u8);
        let mut server = Server::new(Inside { slot, addresses });
        // A flash that cannot be read takes no update.
        if let Ok(slots) = server.slots() {
            device.node().attach_update(&slots);
        }
        server
    }

    /// Reads what the flash holds. A board that still has the device number of the factory set is numbered by
    /// its chip.
    #[inline(never)]
    fn open(storage: &mut CodeFlash<Region>) -> Opened {
        storage.begin(FlashTask::Open);
        let report = loop {
            if let Some(report) = storage.step() {
                break report;
            }
        };
        let FlashReply::Opened(mut opened) = report else { reset::fail() };
        if opened.parameters.raw(number::DEVICE_NUMBER) == Parameters::new().raw(number::DEVICE_NUMBER) {
            let _ = opened.parameters.set(number::DEVICE_NUMBER, reset::serial().into());
        }
        opened
    }

    /// The control interrupt: the converters have sampled.
    #[interrupt]
    fn ADC1_2() {
        CONTROL.with(|control| control.interrupt());
    }

    /// A commutation inside the period.
    #[interrupt]
    fn TIM4() {
        BRIDGE.with(Bridge::commutate);
    }

    #[interrupt]
    fn FDCAN1_IT0() {
        fdcan::interrupt();
    }

    /// Identity of this image.
    const IDENTITY: Identity = Identity {
        build_number: 1,
        source_modified: false,
        build_date: 20_261_122,
        hardware_release: 3,
        software_release: 0x0001,
    };
}
