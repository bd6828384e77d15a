//! The independent watchdog: its own oscillator, and nothing stops it once it runs.

use stm32_metapac::IWDG;
use stm32_metapac::iwdg::regs::{Kr, Rlr};
use stm32_metapac::iwdg::vals::{Key, Pr};

/// 100 ms at 32 kHz / 16: several erased pages of 22 ms, with the loop between them. The oscillator may be 10 % off.
const RELOAD: u16 = 200;

fn key(key: Key) {
    let mut word = Kr(0);
    word.set_key(key);
    IWDG.kr().write_value(word);
}

pub(super) fn start() {
    key(Key::START);
    key(Key::ENABLE);
    IWDG.pr().modify(|prescaler| prescaler.set_pr(Pr::DIVIDE_BY16));
    let mut reload = Rlr(0);
    reload.set_rl(RELOAD);
    IWDG.rlr().write_value(reload);
    feed();
}

/// Starts its time anew.
pub fn feed() {
    key(Key::RESET);
}
