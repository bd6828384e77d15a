//! The drive: control in the converters' interrupt, the node in a task of embassy.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use core::cell::RefCell;
    use embassy_embedded_hal::flash::partition::BlockingPartition;
    use embassy_executor::Spawner;
    use embassy_stm32::can::{self, CanConfigurator, CanRx, CanTx};
    use embassy_stm32::flash::{Blocking, Flash, MAX_ERASE_SIZE};
    use embassy_stm32::interrupt;
    use embassy_stm32::interrupt::{InterruptExt, Priority};
    use embassy_stm32::peripherals::FDCAN2;
    use embassy_stm32::wdg::IndependentWatchdog;
    use embassy_stm32::{Config, bind_interrupts};
    use embassy_sync::blocking_mutex::Mutex;
    use embassy_sync::blocking_mutex::raw::NoopRawMutex;
    use embassy_time::{Duration, Ticker};
    use narx_board::owned::Owned;
    use narx_board::shell::{Background, Control, Progress};
    use narx_core::device::Queues;
    use narx_core::node::Identity;
    use narx_core::scope::Memory;
    use narx_core::storage::{CodeFlash, FlashReply, FlashTask, Mailbox};
    use narx_embassy_stm32::board::BOARD;
    use narx_embassy_stm32::bridge::{self, BRIDGE, Bridge};
    use narx_embassy_stm32::sides::{Node, Tick};
    use narx_embassy_stm32::{clock, converter, frames, pins};
    use static_cell::StaticCell;

    bind_interrupts!(struct Interrupts {
        FDCAN2_IT0 => can::IT0InterruptHandler<FDCAN2>;
        FDCAN2_IT1 => can::IT1InterruptHandler<FDCAN2>;
    });

    type Flashed = Mutex<NoopRawMutex, RefCell<Flash<'static, Blocking>>>;
    type Pages = BlockingPartition<'static, NoopRawMutex, Flash<'static, Blocking>>;

    /// The control interrupt's.
    static CONTROL: Owned<Control<'static, 'static, Tick>> = Owned::nothing();
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

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
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
        CONTROL.give(Control::new(tick, Tick::default(), &PROGRESS));
        BRIDGE.give(Bridge::default());
        let mut watchdog = IndependentWatchdog::new(parts.IWDG, 100_000);
        watchdog.unleash();
        let mailbox: &'static Mailbox = MAILBOX.init_with(Mailbox::new);
        let background =
            Background::new(device, Node { bus, watchdog }, &PROGRESS).with_flash(mailbox, &opened);

        // Commutations strike everything else, the control tick everything of embassy.
        interrupt::TIM2.set_priority(Priority::P0);
        interrupt::ADC1_2.set_priority(Priority::P1);
        for other in [interrupt::TIM5, interrupt::FDCAN2_IT0, interrupt::FDCAN2_IT1] {
            other.set_priority(Priority::P2);
        }
        // The interrupts take what was given to them above.
        unsafe {
            interrupt::TIM2.enable();
            interrupt::ADC1_2.enable();
        }
        bridge::run();
        spawner.spawn(receive(receiver).expect("the first"));
        spawner.spawn(send(sender).expect("the first"));
        spawner.spawn(node(background, mailbox, storage).expect("the first"));
    }

    #[embassy_executor::task]
    async fn receive(bus: CanRx<'static>) -> ! {
        frames::receive(bus).await
    }

    #[embassy_executor::task]
    async fn send(bus: CanTx<'static>) -> ! {
        frames::send(bus).await
    }

    /// The node, every 200 us, and the flash between two passes.
    #[embassy_executor::task]
    async fn node(
        mut background: Background<'static, 'static, Node>,
        mailbox: &'static Mailbox,
        mut storage: CodeFlash<Pages>,
    ) -> ! {
        let mut passes = Ticker::every(Duration::from_micros(200));
        loop {
            background.pass();
            mailbox.serve_step(&mut storage);
            passes.next().await;
        }
    }

    #[interrupt]
    fn ADC1_2() {
        CONTROL.with(Control::interrupt);
    }

    #[interrupt]
    fn TIM2() {
        BRIDGE.with(Bridge::commutate);
    }
}
