//! The chip's registers (RM0440), a part a file. `unsafe` stands in `memory` and `reset` alone, where
//! addresses become bytes.

pub mod background;
pub mod capture;
pub mod clock;
pub mod converter;
pub mod fdcan;
pub mod memory;
pub mod ports;
pub mod power_stage;
pub mod reset;
pub mod self_test;
pub mod tick;
pub mod watchdog;

use cortex_m::peripheral::NVIC;
use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use stm32_metapac::Interrupt;

/// Interrupts by urgency: commutations strike any other; frames wait for a control tick.
const URGENCY: [(Interrupt, u8); 3] =
    [(Interrupt::TIM4, 0x00), (Interrupt::ADC1_2, 0x10), (Interrupt::FDCAN1_IT0, 0x20)];

/// Clocks, pins, peripherals, with the gates off. Interrupts come with [`listen`].
pub fn start() {
    watchdog::start_slow();
    clock::start();
    ports::start();
    power_stage::start();
    capture::start();
    converter::start();
    fdcan::start();
}

/// Starts what a bootloader needs: the watchdog, which goes on into the application, and the LED. The clock
/// stays the internal one of 16 MHz, which cannot fail.
pub fn start_for_boot() {
    watchdog::start_slow();
    ports::start_led();
}

/// Starts what a bootloader needs beside that to receive: clocks, pins, the bus; the gates stay off.
pub fn start_for_loading() -> Clock {
    clock::start();
    ports::start();
    fdcan::start();
    let Some(mut core) = cortex_m::Peripherals::take() else { reset::fail() };
    core.SYST.set_clock_source(SystClkSource::Core);
    core.SYST.set_reload(1000 * clock::PER_US - 1);
    core.SYST.clear_current();
    core.SYST.enable_counter();
    core.SYST.enable_interrupt();
    let [.., (bus, urgency)] = URGENCY;
    reset::enable(&mut core.NVIC, bus, urgency);
    Clock { timer: core.SYST, milliseconds: 0 }
}

/// Milliseconds, as far as somebody looks at least once in each: it stands still while a page is erased. Each
/// wakes a processor that sleeps.
pub struct Clock {
    timer: SYST,
    milliseconds: u64,
}

impl Clock {
    /// Time since the start.
    pub fn milliseconds(&mut self) -> u64 {
        self.milliseconds += u64::from(self.timer.has_wrapped());
        self.milliseconds
    }
}

/// The bootloader receives: the LED flickers, and the watchdog waits.
pub fn show_loading(now_ms: u64) {
    watchdog::feed();
    ports::set_led((now_ms / 100).is_multiple_of(2));
}

/// The flash cannot be read: the LED flickers until somebody repairs the board.
pub fn stay() -> ! {
    loop {
        watchdog::feed();
        ports::toggle_led();
        // 0.1 s at 16 MHz.
        cortex_m::asm::delay(1_600_000);
    }
}

/// Lets the interrupts in: what they own has been given to them. From here on the watchdog waits for nobody.
pub fn listen(nvic: &mut NVIC) {
    watchdog::start();
    for (interrupt, urgency) in URGENCY {
        reset::enable(nvic, interrupt, urgency);
    }
    power_stage::run();
}

/// Waits for a flag that hardware sets. One that never comes ends in the watchdog's reset, with the gates
/// off.
fn wait_for(flag: impl Fn() -> bool) {
    while !flag() {}
}
