//! Self-tests of the board: RAM at boot, and all the time its program, the end of its stack, and control
//! ticks against the oscillator of 32 kHz, which has nothing in common with the crystal.

use narx_board::self_test::clock::{TickMonitor, Tolerance};
use narx_board::self_test::walk::Walk;
use narx_core::node::SelfTests;
use narx_firmware::boards::cortex_m;
use stm32_metapac::rcc::vals::Lptimsel;
use stm32_metapac::{LPTIM1, RCC};

/// The oscillator's nominal rate, Hz: within 5 % (DS12589, features). Of the STM32WLE5's ST promises 29.5 to
/// 34 kHz over supply and temperature.
const OSCILLATOR: u16 = 32_000;
/// The tick's rate, likewise.
const TICK_RATE: u16 = crate::timing::TICK_RATE as u16;
const _: () = assert!(TICK_RATE as u32 == crate::timing::TICK_RATE);
/// Fast: the oscillator's own error. Slow: ticks that are lost while pages are erased, too.
const TOLERANCE: Tolerance = Tolerance { slow: 400, fast: 120 };
/// The walk over the program takes this much at a time: two seconds for the whole image, 0.2 ms each.
const WALK_BYTES: usize = 512;

/// Tests that go on.
pub struct Tests {
    failed: SelfTests,
    walk: Walk,
    monitor: TickMonitor,
    /// The oscillator's counts; its register has 16 bits.
    counts: u32,
}

impl Tests {
    /// At boot, with no interrupt on and the watchdog slow; RAM is tested here.
    pub fn boot() -> Self {
        start_counter();
        let failed = if cortex_m::is_ram_sound() { SelfTests::empty() } else { SelfTests::RAM };
        let walk = Walk::new(cortex_m::program());
        let counts = counter().into();
        let monitor = TickMonitor::new(TICK_RATE, OSCILLATOR, TOLERANCE, OSCILLATOR.into(), counts);
        Self { failed, walk, monitor, counts }
    }

    /// A piece of the tests, at least every second; all that have failed.
    pub(super) fn step(&mut self, ticks: u64) -> SelfTests {
        let passed = counter().wrapping_sub(self.counts as u16);
        self.counts = self.counts.wrapping_add(passed.into());
        if !cortex_m::is_stack_end_untouched() {
            self.failed |= SelfTests::STACK;
        }
        self.failed.set(SelfTests::FLASH, !self.walk.step(cortex_m::program(), WALK_BYTES));
        self.failed.set(SelfTests::TICK, !self.monitor.step(ticks, self.counts));
        self.failed
    }
}

/// LPTIM1 counts the oscillator (LPTIM1SEL in RCC_CCIPR: ST's stm32g431xx.h) and wraps every two seconds.
fn start_counter() {
    RCC.csr().modify(|control| control.set_lsion(true));
    super::wait_for(|| RCC.csr().read().lsirdy());
    RCC.ccipr().modify(|select| select.set_lptim1sel(Lptimsel::LSI));
    RCC.apb1enr1().modify(|enable| enable.set_lptim1en(true));
    LPTIM1.cr().modify(|control| control.set_enable(true));
    LPTIM1.arr().modify(|limit| limit.set_arr(u16::MAX));
    LPTIM1.cr().modify(|control| control.set_cntstrt(true));
}

/// Read until it is the same twice: the counter knows nothing of the bus's clock (RM0440, section 34.4.13).
fn counter() -> u16 {
    let mut count = LPTIM1.cnt().read().cnt();
    loop {
        let again = LPTIM1.cnt().read().cnt();
        if again == count {
            return count;
        }
        count = again;
    }
}
