//! The independent watchdog: its own oscillator, and nothing stops it once it runs.

use stm32_metapac::IWDG;
use stm32_metapac::iwdg::regs::{Kr, Rlr};
use stm32_metapac::iwdg::vals::{Key, Pr};

/// 100 ms at 32 kHz / 16: several erased pages of 22 ms, with the loop between them. The oscillator may be 10
/// % off.
const RELOAD: u16 = 200;

fn key(key: Key) {
    let mut word = Kr(0);
    word.set_key(key);
    IWDG.kr().write_value(word);
}

/// For the application's loop: see [`RELOAD`].
pub(super) fn start() {
    run(Pr::DIVIDE_BY16, RELOAD);
}

/// For what comes before: 32 s. RAM and program are tested in it; in the bootloader, at 16 MHz, a signature
/// takes a second, and a swap of 25 pages three.
pub(super) fn start_slow() {
    run(Pr::DIVIDE_BY256, 4000);
}

fn run(prescaler: Pr, reload: u16) {
    key(Key::START);
    key(Key::ENABLE);
    // What was written before takes some of the oscillator's periods to arrive.
    super::wait_for(|| IWDG.sr().read().0 == 0);
    IWDG.pr().modify(|register| register.set_pr(prescaler));
    let mut word = Rlr(0);
    word.set_rl(reload);
    IWDG.rlr().write_value(word);
    super::wait_for(|| IWDG.sr().read().0 == 0);
    feed();
}

/// Starts its time anew.
pub fn feed() {
    key(Key::RESET);
}
