//! The drive as tasks of RTIC: commutation and control in interrupts, the node and CAN in software tasks.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(clippy::result_large_err, reason = "a spawn that RTIC refuses gives its arguments back")]

#[cfg(not(target_os = "none"))]
fn main() {}

// Commutations strike everything else, the control tick everything but them.
#[cfg(target_os = "none")]
#[rtic::app(device = embassy_stm32, peripherals = false, dispatchers = [SPI1, SPI2])]
mod app {
    use core::cell::RefCell;
    use embassy_embedded_hal::flash::partition::BlockingPartition;
    use embassy_stm32::can::{self, CanConfigurator, CanRx, CanTx};
    use embassy_stm32::flash::{Blocking, Flash, MAX_ERASE_SIZE};
    use embassy_stm32::interrupt::{self, InterruptExt, Priority};
    use embassy_stm32::peripherals::FDCAN2;
    use embassy_stm32::wdg::IndependentWatchdog;
    use embassy_stm32::{Config, bind_interrupts};
    use embassy_sync::blocking_mutex::Mutex;
    use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
    use embassy_time::{Duration, Ticker};
    use narx_board::shell::{Background, Control, Progress};
    use narx_core::device::{self, Queues};
    use narx_core::node::Identity;
    use narx_core::scope::Memory;
    use narx_core::storage::{CodeFlash, FlashReply, FlashTask, Mailbox, Opened};
    use narx_embassy_stm32::board::BOARD;
    use narx_embassy_stm32::bridge::{self, BRIDGE, Bridge};
    use narx_embassy_stm32::sides::{Node, Tick};
    use narx_embassy_stm32::{clock, converter, frames, pins};
    use static_cell::StaticCell;

    bind_interrupts!(struct Interrupts {
        FDCAN2_IT0 => can::IT0InterruptHandler<FDCAN2>;
        FDCAN2_IT1 => can::IT1InterruptHandler<FDCAN2>;
    });

    type Flashed = Mutex<CriticalSectionRawMutex, RefCell<Flash<'static, Blocking>>>;
    type Pages = BlockingPartition<'static, CriticalSectionRawMutex, Flash<'static, Blocking>>;

    static PROGRESS: Progress = Progress::new();
    static QUEUES: StaticCell<Queues<'static>> = StaticCell::new();
    static SCOPE: StaticCell<Memory<[u16; 16_384]>> = StaticCell::new();
    static FLASH: StaticCell<Flashed> = StaticCell::new();
    static MAILBOX: StaticCell<Mailbox> = StaticCell::new();

    /// Identity of this image.
    const IDENTITY: Identity = Identity {
        build_number: 1,
        source_modified: false,
        build_date: 20_261_127,
        hardware_release: 1,
        software_release: 0x0001,
    };

    /// Pages at the end of the second bank, in which the parameters are kept.
    const PAGES: u32 = 4 * MAX_ERASE_SIZE as u32;
    const FLASH_BYTES: u32 = 512 << 10;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        control: Control<'static, 'static, Tick>,
    }

    #[init]
    fn init(_: init::Context) -> (Shared, Local) {
        let mut config = Config::default();
        clock::set(&mut config.rcc);
        let parts = embassy_stm32::init(config);
        // The timer drives the gates off before the pins are its own.
        bridge::start();
        pins::start();
        converter::start();

        let mut bus = CanConfigurator::new(parts.FDCAN2, parts.PB12, parts.PB13, Interrupts);
        frames::configure(&mut bus);
        let (sender, receiver, bus) = bus.into_normal_mode().split();
        let flash = FLASH.init(Mutex::new(RefCell::new(Flash::new_blocking(parts.FLASH))));
        let mut storage = CodeFlash::new(BlockingPartition::new(flash, FLASH_BYTES - PAGES, PAGES));
        storage.begin(FlashTask::Open);
        let report = loop {
            if let Some(report) = storage.step() {
                break report;
            }
        };
        let FlashReply::Opened(opened) = report else { panic!("the flash cannot be read") };

        let queues = QUEUES.init_with(Queues::new);
        let (tick, mut device) = queues.power_up(IDENTITY, BOARD, opened.parameters.clone());
        device.attach_scope(SCOPE.init_with(Memory::new));
        device.node().store_at_rest_only();
        BRIDGE.give(Bridge::default());
        let mut watchdog = IndependentWatchdog::new(parts.IWDG, 100_000);
        watchdog.unleash();

        // RTIC sets the priorities of its own tasks only; these are embassy's interrupts.
        for other in [interrupt::TIM5, interrupt::FDCAN2_IT0, interrupt::FDCAN2_IT1] {
            other.set_priority(Priority::P13);
        }
        bridge::run();
        let _ = receive::spawn(receiver);
        let _ = send::spawn(sender);
        let _ = node::spawn(device, Node { bus, watchdog }, storage, opened);
        (Shared {}, Local { control: Control::new(tick, Tick::default(), &PROGRESS) })
    }

    #[task(binds = TIM2, priority = 16)]
    fn commutate(_: commutate::Context) {
        BRIDGE.with(Bridge::commutate);
    }

    #[task(binds = ADC1_2, priority = 15, local = [control])]
    fn control(context: control::Context) {
        context.local.control.interrupt();
    }

    #[task(priority = 2)]
    async fn receive(_: receive::Context, bus: CanRx<'static>) -> ! {
        frames::receive(bus).await
    }

    #[task(priority = 2)]
    async fn send(_: send::Context, bus: CanTx<'static>) -> ! {
        frames::send(bus).await
    }

    /// The node, every 200 us, and the flash between two passes.
    #[task(priority = 1)]
    async fn node(
        _: node::Context,
        device: device::Background<'static, 'static>,
        side: Node,
        mut storage: CodeFlash<Pages>,
        opened: Opened,
    ) -> ! {
        // Between the two halves of this task alone, so it is made here.
        let mailbox: &'static Mailbox = MAILBOX.init_with(Mailbox::new);
        let mut background = Background::new(device, side, &PROGRESS).with_flash(mailbox, &opened);
        let mut passes = Ticker::every(Duration::from_micros(200));
        loop {
            background.pass();
            mailbox.serve_step(&mut storage);
            passes.next().await;
        }
    }
}
