//! UART0 (Arm, *Cortex-M System Design Kit*, APB UART): the serial port of the slcan adapter.

use super::register::Register;
use cortex_m::interrupt::InterruptNumber;
use cortex_m::peripheral::NVIC;
use heapless::Deque;
use heapless::spsc::{Consumer, Producer, Queue};
use narx_core::queue::{dequeue, enqueue, has_room};

/// Number of the interrupt: a byte was received.
pub const RECEIVED: u16 = 0;

/// Bytes that wait to be sent.
const OUTGOING: usize = 8192;
/// Bytes that wait to be read, one of which stays free.
pub const INCOMING: usize = 4096;

// SAFETY: UART0 of this machine (MPS2, application note 386) stands at 4000_4000h.
const DATA: Register = unsafe { Register::new(0x4000_4000) };
// SAFETY: the same UART.
const STATE: Register = unsafe { Register::new(0x4000_4004) };
// SAFETY: the same UART.
const CONTROL: Register = unsafe { Register::new(0x4000_4008) };
// SAFETY: the same UART.
const INTERRUPT_CLEAR: Register = unsafe { Register::new(0x4000_400C) };
// SAFETY: the same UART.
const BAUD_DIVISOR: Register = unsafe { Register::new(0x4000_4010) };

const TRANSMIT_FULL: u32 = 1 << 0;
const RECEIVE_FULL: u32 = 1 << 1;
/// Transmitter, receiver and the receiver's interrupt on.
const ENABLE: u32 = 0b1011;
const RECEIVE_INTERRUPT: u32 = 1 << 1;

/// The interrupt of [`RECEIVED`].
#[derive(Clone, Copy)]
pub struct Received;

// SAFETY: the one interrupt has the one number.
unsafe impl InterruptNumber for Received {
    fn number(self) -> u16 {
        RECEIVED
    }
}

/// The background's side.
pub struct Uart {
    outgoing: Deque<u8, OUTGOING>,
    incoming: Consumer<'static, u8>,
}

/// The interrupt's side.
pub struct Receiver {
    incoming: Producer<'static, u8>,
}

/// Turns the UART on. Its interrupt comes once [`Uart::listen`] was called.
pub fn open(queue: &'static mut Queue<u8, INCOMING>) -> (Uart, Receiver) {
    // Nobody measures the bits of an emulated line: the smallest divisor there is.
    BAUD_DIVISOR.write(16);
    CONTROL.write(ENABLE);
    let (producer, consumer) = queue.split();
    (Uart { outgoing: Deque::new(), incoming: consumer }, Receiver { incoming: producer })
}

impl Uart {
    /// Lets the receiver's interrupt come.
    pub fn listen(&self) {
        // SAFETY: the receiver was given to the interrupt before, and no critical section relies on its mask.
        unsafe { NVIC::unmask(Received) };
    }

    /// The next byte that has arrived.
    pub fn read(&mut self) -> Option<u8> {
        let byte = dequeue(&mut self.incoming);
        if byte.is_none() {
            // A full queue leaves its next byte in the UART, and no interrupt comes for it again.
            NVIC::pend(Received);
        }
        byte
    }

    /// Bytes that [`write`](Self::write) has room for.
    pub fn room(&self) -> usize {
        OUTGOING - self.outgoing.len()
    }

    /// Queues all of `bytes`; false, and nothing is queued, if they do not fit.
    pub fn write(&mut self, bytes: &[u8]) -> bool {
        let fits = bytes.len() <= self.room();
        if fits {
            bytes.iter().for_each(|byte| {
                // There is room for all.
                let _ = self.outgoing.push_back(*byte);
            });
        }
        fits
    }

    /// Sends what the line takes now; false when nothing is left.
    pub fn pump(&mut self) -> bool {
        while STATE.read() & TRANSMIT_FULL == 0 {
            let Some(byte) = self.outgoing.pop_front() else { return false };
            DATA.write(byte.into());
        }
        true
    }
}

impl Receiver {
    /// The body of the interrupt.
    pub fn interrupt(&mut self) {
        // First, for a byte that comes while the others are read must ask again.
        INTERRUPT_CLEAR.write(RECEIVE_INTERRUPT);
        while has_room(&self.incoming) && STATE.read() & RECEIVE_FULL != 0 {
            // Room was just seen.
            let _ = enqueue(&mut self.incoming, DATA.read() as u8);
        }
    }
}
