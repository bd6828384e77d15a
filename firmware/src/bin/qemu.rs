//! The virtual drive: `qemu [--motor NAME] [--supply V]`, a commissioned hall drive on the emulated board, with slcan on UART0.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod image {
    use core::fmt;
    use cortex_m::peripheral::scb::SystemHandler;
    use cortex_m_rt::{entry, exception};
    use cortex_m_semihosting::hprintln;
    use heapless::spsc::Queue;
    use narx_core::device::Queues;
    use narx_core::motor::{Board, PwmCommand, Samples};
    use narx_core::node::Identity;
    use narx_core::scope::{self, Memory};
    use narx_core::storage::{Mailbox, Opened, Report, Request, Storage};
    use narx_firmware::boards::qemu::flash::Chip;
    use narx_firmware::boards::qemu::pace::{Pace, count_millisecond};
    use narx_firmware::boards::qemu::uart::{self, INCOMING, Receiver};
    use narx_firmware::boards::qemu::watchdog::Watchdog;
    use narx_firmware::boards::qemu::world::{Period, World};
    use narx_firmware::boards::qemu::{ARGUMENTS_MAX, MOTOR, Owned, kept_settings, semihosting};
    use narx_firmware::shell::{Background, Control, Progress};
    use narx_sim::can::slcan::Adapter;
    use narx_sim::commissioning::{Commissioning, Mode, Nameplate};
    use narx_sim::flash::finish;
    use narx_sim::plant::{Plant, PlantConfig};
    use narx_sim::presets::{Preset, preset};

    /// The control interrupt's.
    static CONTROL: Owned<Control<'static, 'static, Period>> = Owned::nothing();
    /// The UART interrupt's.
    static RECEIVER: Owned<Receiver> = Owned::nothing();
    static PROGRESS: Progress = Progress::new();

    #[entry]
    fn main() -> ! {
        static mut QUEUES: Queues<'static> = Queues::new();
        static mut SAMPLES: Queue<Samples, 2> = Queue::new();
        static mut COMMANDS: Queue<PwmCommand, 2> = Queue::new();
        static mut INCOMING_BYTES: Queue<u8, INCOMING> = Queue::new();
        static mut ARGUMENTS: [u8; ARGUMENTS_MAX] = [0; ARGUMENTS_MAX];
        static mut MAILBOX: Mailbox = Mailbox::new();
        static mut SCOPE: Memory<[u16; scope::WORDS]> = Memory::new();

        let Some((preset, supply)) = choose(semihosting::arguments(ARGUMENTS)) else {
            semihosting::exit(false)
        };
        let commissioning = match commission(preset, supply) {
            Ok(commissioning) => commissioning,
            Err(error) => fail(&error),
        };
        let Some(mut peripherals) = cortex_m::Peripherals::take() else { semihosting::exit(false) };
        // SAFETY: no interrupt is on yet.
        unsafe {
            // Smaller is more urgent: the control tick, then bytes (0x80), then the clock.
            peripherals.SCB.set_priority(SystemHandler::PendSV, 0);
            peripherals.NVIC.set_priority(uart::Received, 0x80);
            peripherals.SCB.set_priority(SystemHandler::SysTick, 0xC0);
        }

        let mailbox: &'static Mailbox = MAILBOX;
        let Some(chip) = Chip::take() else { semihosting::exit(false) };
        let mut storage = Storage::new(chip);
        let Some(opened) = open(&mut storage, &commissioning) else { semihosting::exit(false) };
        let (tick, mut device) = QUEUES.power_up(IDENTITY, Board::BENCH, opened.parameters.clone());
        device.attach_scope(SCOPE);
        let (samples, samples_out) = SAMPLES.split();
        let (commands_in, commands) = COMMANDS.split();
        let (uart, receiver) = uart::open(INCOMING_BYTES);
        CONTROL.give(Control::new(tick, Period { samples: samples_out, commands: commands_in }, &PROGRESS));
        RECEIVER.give(receiver);
        uart.listen();
        hprintln!("narx on mps2-an386: {} at {} V, hall closed loop, slcan on UART0", preset.name, supply);
        let world = World {
            plant: Plant::new(&PlantConfig { angle_deg: 77.0, ..PlantConfig::new(preset.motor, supply) }),
            samples,
            commands,
            uart,
            adapter: Adapter::with_settings(kept_settings()),
            pace: Pace::start(peripherals.SYST),
            watchdog: Watchdog::start(),
            stack: 0,
            bus_free_at: 0,
        };
        storage.flash().start_clock();
        Background::new(device, world, &PROGRESS)
            .with_flash(mailbox, &opened)
            .run_with(mailbox.serve(&mut storage))
    }

    /// What the flash holds. One that holds nothing, as after power-up, becomes that of a commissioned drive.
    fn open(storage: &mut Storage<Chip>, commissioning: &Commissioning) -> Option<Opened> {
        let look = |storage: &mut Storage<Chip>| match finish(storage.execute(Request::Open)) {
            Some(Report::Opened(opened)) => Some(opened),
            _ => None,
        };
        let opened = look(storage)?;
        if opened.faults.is_empty() {
            return Some(opened);
        }
        storage.flash().clear();
        finish(storage.format(&commissioning.parameters))?;
        look(storage)
    }

    /// The control interrupt.
    #[exception]
    fn PendSV() {
        CONTROL.with(Control::interrupt);
    }

    #[exception]
    fn SysTick() {
        count_millisecond();
    }

    /// The other interrupts; only the UART's is on.
    #[exception]
    unsafe fn DefaultHandler(number: i16) {
        if number == uart::RECEIVED as i16 {
            RECEIVER.with(Receiver::interrupt);
        }
    }

    /// The watchdog, the first time: the second resets the machine.
    #[exception]
    unsafe fn NonMaskableInt() -> ! {
        hprintln!("watchdog: control, CAN or background has stood still");
        loop {
            cortex_m::asm::nop();
        }
    }

    /// What the image says of itself.
    const IDENTITY: Identity = Identity {
        build_number: 1,
        source_modified: false,
        build_date: 20_261_121,
        hardware_release: 2,
        software_release: 0x0001,
    };

    /// Motor and supply voltage; nothing, and a word why, if the arguments are none.
    fn choose<'a>(mut arguments: impl Iterator<Item = &'a str>) -> Option<(&'static Preset, f64)> {
        let mut motor = MOTOR;
        let mut supply = None;
        while let Some(option) = arguments.next() {
            match (option, arguments.next()) {
                ("--motor", Some(name)) => motor = name,
                ("--supply", Some(volts)) if volts.parse::<u8>().is_ok() => supply = volts.parse::<u8>().ok(),
                (option, value) => {
                    hprintln!("{} {}: expected --motor NAME or --supply VOLTS", option, value.unwrap_or(""));
                    return None;
                }
            }
        }
        let Some(preset) = preset(motor) else {
            hprintln!("--motor {}: no such motor", motor);
            return None;
        };
        Some((preset, supply.map_or(preset.data.nominal_voltage, f64::from)))
    }

    fn commission(preset: &Preset, supply: f64) -> Result<Commissioning, impl fmt::Display> {
        let plate = Nameplate {
            motor: preset.motor,
            rated_current: preset.data.rated_current,
            supply,
            open_loop_speed: None,
        };
        plate.commission(Mode::Hall)
    }

    fn fail(error: &dyn fmt::Display) -> ! {
        hprintln!("{}", error);
        semihosting::exit(false)
    }
}
