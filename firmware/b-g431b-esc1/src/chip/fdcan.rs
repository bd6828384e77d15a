//! FDCAN1 as a classic controller: 29-bit identifiers to FIFO 0, 11-bit ones to FIFO 1, three transmit
//! buffers in the order in which they were filled. (As a queue by urgency the controller would let frames of
//! one identifier overtake each other.)

use super::wait_for;
use crate::can::{BIT_RATE, BitTiming, CLOCK_HZ, bus_state, decode, encode};
use heapless::spsc::Producer;
use narx_board::owned::Owned;
use narx_core::bus::{BusState, Frame};
use stm32_metapac::can::regs::{Ie, Ile, Ir, Nbtp, Rxfa, Rxgfc, Txbar, Txbc, Txbcr};
use stm32_metapac::{FDCAN1, FDCANRAM1};

/// Frames that can wait for the background: at full load it may be busy for 6 ms.
pub const WAITING: usize = 32;
/// The interrupt's.
pub static ARRIVING: Owned<Producer<'static, Frame>> = Owned::nothing();

const TIMING: BitTiming = match BitTiming::of(CLOCK_HZ, BIT_RATE) {
    Some(timing) => timing,
    None => panic!("the crystal cannot be divided into bits"),
};
/// Buffers, and elements of a FIFO.
const BUFFERS: usize = 3;
const ALL: u32 = (1 << BUFFERS) - 1;
/// Words of an element.
const ELEMENT: usize = 18;
/// Interrupts: a new element in FIFO 0 or 1.
const ARRIVED: u32 = 1 << 0 | 1 << 3;

pub(super) fn start() {
    FDCAN1.cccr().modify(|control| control.set_init(true));
    wait_for(|| FDCAN1.cccr().read().init());
    FDCAN1.cccr().modify(|control| control.set_cce(true));
    FDCAN1.nbtp().write_value(Nbtp(TIMING.register()));
    // No filters: what has 29 bits to FIFO 0, what has 11 to FIFO 1. A full FIFO keeps what it has.
    FDCAN1.rxgfc().write_value(Rxgfc(0b01 << 4));
    FDCAN1.txbc().write_value(Txbc(0));
    FDCAN1.ie().write_value(Ie(ARRIVED));
    FDCAN1.ile().write_value(Ile(1));
    FDCAN1.cccr().modify(|control| control.set_init(false));
}

/// The body of the interrupt: what has arrived waits in memory, in its FIFO's order. What finds no room is
/// lost.
pub fn interrupt() {
    FDCAN1.ir().write_value(Ir(ARRIVED));
    ARRIVING.with(|arriving| {
        for fifo in [0, 1] {
            while let Some(frame) = take(fifo) {
                let _ = frame.map(|frame| arriving.enqueue(frame));
            }
        }
    });
}

/// The oldest element of a FIFO, if there is one; `Some(None)` is one that is no frame.
fn take(fifo: usize) -> Option<Option<Frame>> {
    let status = FDCAN1.rxfs(fifo).read();
    if status.ffl() == 0 {
        return None;
    }
    let element = ELEMENT * (usize::from(status.fgi()) % BUFFERS);
    let words = [0, 1, 2, 3].map(|word| match fifo {
        0 => FDCANRAM1.rxfifo0(element + word).read(),
        _ => FDCANRAM1.rxfifo1(element + word).read(),
    });
    FDCAN1.rxfa(fifo).write_value(Rxfa(status.fgi().into()));
    Some(decode(words))
}

/// Buffers that are free.
pub fn room() -> usize {
    usize::from(FDCAN1.txfqs().read().tffl())
}

/// Returns whether no frame waits to be sent.
pub(super) fn is_idle() -> bool {
    FDCAN1.txbrp().read().0 & ALL == 0
}

/// Returns whether at most one frame waits, the one on the bus.
pub(super) fn has_room_for_bulk() -> bool {
    (FDCAN1.txbrp().read().0 & ALL).count_ones() <= 1
}

/// Puts a frame into a free buffer, which has just been seen.
pub fn send(frame: &Frame) {
    let buffer = usize::from(FDCAN1.txfqs().read().tfqpi()) % BUFFERS;
    for (word, value) in encode(frame).into_iter().enumerate() {
        FDCANRAM1.txbuf(ELEMENT * buffer + word).write_value(value);
    }
    FDCAN1.txbar().write_value(Txbar(1 << buffer));
}

/// Takes back what has not been sent.
pub(super) fn discard() {
    FDCAN1.txbcr().write_value(Txbcr(ALL));
}

/// Error state and counters. A controller that has gone bus-off is let back: it waits for 129 times 11
/// recessive bits by itself.
pub fn state() -> BusState {
    let state = bus_state(FDCAN1.psr().read().0, FDCAN1.ecr().read().0);
    if state.is_off() && FDCAN1.cccr().read().init() {
        FDCAN1.cccr().modify(|control| control.set_init(false));
    }
    state
}
