//! The flash of the board: the simulated one, in the PSRAM, which a reset leaves alone and the emulator can
//! keep in a file; as slow as a real one.

use super::slots;
use core::future::poll_fn;
use core::num::NonZeroU64;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use core::task::Poll;
use embedded_storage_async::nor_flash::{ErrorType, MultiwriteNorFlash, NorFlash, ReadNorFlash};
use narx_sim::flash::{Flash, FlashError, KBYTE_512};

/// Bytes of the flash.
const BYTES: usize = 512 << 10;

/// In the PSRAM, behind the slots.
const MEMORY: usize = slots::START + (8 << 20);
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Control ticks since power-up, their low 32 bits.
static NOW: AtomicU32 = AtomicU32::new(0);

/// Tells the flash the time.
pub(super) fn set_now(tick: u64) {
    NOW.store(tick as u32, Ordering::Relaxed);
}

/// Control ticks since power-up, their low 32 bits.
pub fn now() -> u64 {
    NOW.load(Ordering::Relaxed).into()
}

/// The chip on the board.
pub struct Chip {
    model: Flash<&'static mut [u8]>,
    /// Length of a control tick, ns; `None` before the clock was started.
    tick_ns: Option<NonZeroU64>,
    /// Busy time that has not been waited for, below one tick, ns.
    owed: u64,
}

impl Chip {
    /// The one chip, once. It takes no time before its clock was started.
    pub fn take() -> Option<Self> {
        if TAKEN.load(Ordering::Relaxed) {
            return None;
        }
        TAKEN.store(true, Ordering::Relaxed);
        // SAFETY: bytes of the PSRAM that nobody else names, and this point is reached once: no interrupt
        // takes a chip.
        let memory = unsafe { core::slice::from_raw_parts_mut(MEMORY as *mut u8, BYTES) };
        Some(Self { model: Flash::new(KBYTE_512, memory, 0), tick_ns: None, owed: 0 })
    }

    /// From now on operations last. `tick_rate`: control ticks a second.
    pub fn start_clock(&mut self, tick_rate: u16) {
        self.tick_ns = NonZeroU64::new(1_000_000_000 / u64::from(tick_rate.max(1)));
        self.model.take_busy();
    }

    /// All ones, as it comes from its maker.
    pub fn clear(&mut self) {
        self.model.clear();
    }

    /// Until the last operation has ended.
    async fn settle(&mut self) {
        self.owed += self.model.take_busy();
        let Some(tick_ns) = self.tick_ns else { return };
        let ticks = (self.owed / tick_ns) as u32;
        if ticks == 0 {
            return;
        }
        self.owed %= tick_ns;
        let start = NOW.load(Ordering::Relaxed);
        poll_fn(|_| match NOW.load(Ordering::Relaxed).wrapping_sub(start) >= ticks {
            true => Poll::Ready(()),
            false => Poll::Pending,
        })
        .await;
    }
}

impl ErrorType for Chip {
    type Error = FlashError;
}

impl ReadNorFlash for Chip {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        let done = self.model.read(offset, bytes).await;
        self.settle().await;
        done
    }

    fn capacity(&self) -> usize {
        self.model.capacity()
    }
}

impl NorFlash for Chip {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = <Flash<&'static mut [u8]> as NorFlash>::ERASE_SIZE;

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        let done = self.model.write(offset, bytes).await;
        self.settle().await;
        done
    }

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let done = self.model.erase(from, to).await;
        self.settle().await;
        done
    }
}

impl MultiwriteNorFlash for Chip {}
