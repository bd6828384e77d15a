//! The virtual drive, wherever its image stands: a commissioned hall drive on the emulated board, with slcan
//! on UART0.

use core::fmt;
use core::future::poll_fn;
use core::pin::pin;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::hprintln;
use heapless::spsc::Queue;
use narx_board::shell::{Background, Control, Progress};
use narx_boot::{Server, Slot, hardware};
use narx_core::bus::slcan::Adapter;
use narx_core::commissioning::{Commissioning, Mode, Nameplate};
use narx_core::device::Queues;
use narx_core::dictionary::Decimal;
use narx_core::motor::{Board, PwmCommand, Samples};
use narx_core::node::{Identity, ResetCause};
use narx_core::scope::{self, Memory};
use narx_core::storage::{FlashReply, FlashTask, Mailbox, Opened, Storage};
use narx_firmware::boards::cortex_m as image;
use narx_firmware::boards::qemu::flash::{self, Chip};
use narx_firmware::boards::qemu::pace::{Pace, count_millisecond, look_for_millisecond};
use narx_firmware::boards::qemu::slots::{MAP, Slots};
use narx_firmware::boards::qemu::trouble::{Task, Trouble};
use narx_firmware::boards::qemu::uart::{self, INCOMING, Receiver};
use narx_firmware::boards::qemu::watchdog::{self, Watchdog};
use narx_firmware::boards::qemu::world::{Period, Tests, World};
use narx_firmware::boards::qemu::{ARGUMENTS_MAX, MOTOR, Owned, kept, program, semihosting};
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
    static mut PWM_COMMANDS: Queue<PwmCommand, 2> = Queue::new();
    static mut INCOMING_BYTES: Queue<u8, INCOMING> = Queue::new();
    static mut ARGUMENTS: [u8; ARGUMENTS_MAX] = [0; ARGUMENTS_MAX];
    static mut MAILBOX: Mailbox = Mailbox::new();
    static mut SCOPE: Memory<[u16; scope::WORDS]> = Memory::new();

    // Before anything else is in RAM that could not bear it.
    let is_ram_sound = image::is_ram_sound();
    let cause = kept::take_cause();
    let Some(Options { preset, supply, board, watchdog_ms, trouble }) =
        choose(semihosting::arguments(ARGUMENTS))
    else {
        semihosting::exit(false)
    };
    let trouble = report(cause, trouble);
    let commissioning = match commission(preset, supply, &board) {
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
    let (tick, mut device) = QUEUES.power_up(IDENTITY, board, opened.parameters.clone());
    device.attach_scope(SCOPE);
    let mut server = program::is_in_slot()
        .then(|| Slot::new(Slots::new(), MAP, hardware::QEMU).ok())
        .flatten()
        .map(Server::new);
    if let Some(Ok(slots)) = server.as_mut().map(Server::slots) {
        device.node().attach_update(&slots);
    }
    let (samples, samples_out) = SAMPLES.split();
    let (commands_in, commands) = PWM_COMMANDS.split();
    let (uart, receiver) = uart::open(INCOMING_BYTES);
    CONTROL.give(Control::new(
        tick,
        Period { samples: samples_out, commands: commands_in, trouble },
        &PROGRESS,
    ));
    RECEIVER.give(receiver);
    uart.listen();
    // Formatting of floating point can panic, and nothing else here needs it.
    let volts = Decimal { digits: (supply * 10.0) as i64, exponent: -1 };
    hprintln!("narx on mps2-an386: {} at {} V, hall closed loop, slcan on UART0", preset.name, volts);
    // It takes its time, for which no watchdog waits.
    let tick_rate = board.tick_rate as u16;
    let tests = Tests::boot(is_ram_sound, tick_rate);
    let config = PlantConfig { angle_deg: 77.0, board, ..PlantConfig::new(preset.motor, supply) };
    let world = World {
        plant: Plant::new(&config),
        samples,
        commands,
        uart,
        adapter: Adapter::with_settings(kept::settings()),
        pace: Pace::start(peripherals.SYST, tick_rate),
        watchdog: Watchdog::start(watchdog_ms),
        tick_rate,
        stack: 0,
        bus_free_at: 0,
        tests,
        trouble,
        server,
    };
    storage.flash().start_clock(tick_rate);
    let mut serve = pin!(mailbox.serve(&mut storage));
    let task = poll_fn(move |context| {
        if let Some(trouble) = trouble {
            trouble.meet(Task::Flash, flash::now());
        }
        serve.as_mut().poll(context)
    });
    Background::new(device, world, &PROGRESS)
        .with_flash(mailbox, &opened)
        .with_reset_cause(cause)
        .run_with(task)
}

/// Tells what the reset before was; trouble comes once.
fn report(cause: ResetCause, trouble: Option<Trouble>) -> Option<Trouble> {
    if cause == ResetCause::PowerUp {
        return trouble;
    }
    hprintln!("reset: {:?}, {} ms after the trouble", cause, kept::take_hanging());
    None
}

/// Reads what the flash holds. A flash that holds nothing valid, as after power-up, first becomes that of a
/// commissioned drive.
fn open(storage: &mut Storage<Chip>, commissioning: &Commissioning) -> Option<Opened> {
    let look = |storage: &mut Storage<Chip>| match finish(storage.execute(FlashTask::Open)) {
        Some(FlashReply::Opened(opened)) => Some(opened),
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
    kept::note_cause(ResetCause::Watchdog);
    // It comes in the middle of anything, of a line of `hprintln!` too, whose output is taken then.
    semihosting::print(c"watchdog: control, CAN or background has stood still\n");
    loop {
        look_for_millisecond();
    }
}

/// Identity of this image.
const IDENTITY: Identity = Identity {
    build_number: 1,
    source_modified: false,
    build_date: 20_261_121,
    hardware_release: 2,
    software_release: 0x0001,
};

/// Options from the arguments.
struct Options {
    preset: &'static Preset,
    /// V.
    supply: f64,
    board: Board,
    watchdog_ms: u32,
    trouble: Option<Trouble>,
}

/// Parses the arguments; prints the reason and returns `None` if they are not understood.
fn choose<'a>(mut arguments: impl Iterator<Item = &'a str>) -> Option<Options> {
    let mut motor = MOTOR;
    let mut supply = None;
    let mut board = Board::BENCH;
    let mut watchdog_ms = watchdog::PERIOD_MS;
    let (mut task, mut after) = (None, 0);
    while let Some(option) = arguments.next() {
        let value = arguments.next().unwrap_or("");
        let is_understood = match option {
            "--motor" => {
                motor = value;
                true
            }
            "--supply" => value.parse::<u8>().map(|volts| supply = Some(f64::from(volts))).is_ok(),
            "--pwm-rate" => {
                let hertz = value.parse().ok().filter(|hertz| (8_000..=50_000).contains(hertz));
                let parsed = hertz.and_then(|hertz| Board::BENCH.at_rate(hertz));
                parsed.map(|parsed| board = parsed).is_some()
            }
            "--watchdog" => value.parse().map(|ms| watchdog_ms = ms).is_ok(),
            "--after" => value.parse().map(|ticks| after = ticks).is_ok(),
            "--trouble" => {
                task = Task::named(value);
                task.is_some()
            }
            _ => false,
        };
        if !is_understood {
            hprintln!(
                "{} {}: expected --motor NAME, --supply VOLTS, --pwm-rate HZ (8000 to 50000), --watchdog MS, --trouble WHAT or --after TICKS",
                option,
                value
            );
            return None;
        }
    }
    let Some(preset) = preset(motor) else {
        hprintln!("--motor {}: no such motor", motor);
        return None;
    };
    let supply = supply.unwrap_or(preset.data.nominal_voltage);
    Some(Options { preset, supply, board, watchdog_ms, trouble: task.map(|task| Trouble { task, after }) })
}

fn commission(preset: &Preset, supply: f64, board: &Board) -> Result<Commissioning, impl fmt::Display> {
    let plate = Nameplate {
        motor: preset.motor.figures(),
        rated_current: preset.data.rated_current,
        supply,
        open_loop_speed: None,
    };
    plate.commission_on(board, Mode::Hall, None)
}

fn fail(error: &dyn fmt::Display) -> ! {
    hprintln!("{}", error);
    semihosting::exit(false)
}
