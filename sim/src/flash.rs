//! A serial NOR flash: what it does to bits, how long it takes, and what a power cut leaves of it.
//!
//! * A program clears bits and never sets one, within pages of 256 bytes; an erase sets all bits of a
//!   subsector of 4 KiB, or of a sector of 64 KiB where a range holds a whole one.
//! * Every operation takes its time: [`Flash::take_busy`] says how long the chip has been busy.
//! * The power fails at any byte of any operation. What the byte, or the piece of an erase, under way becomes
//!   is a [`Tear`].

use crate::random::Random;
use core::fmt;
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_storage_async::nor_flash::{
    ErrorType, MultiwriteNorFlash, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};
use narx_core::storage::layout;

#[cfg(feature = "alloc")]
mod sparse;
#[cfg(feature = "alloc")]
pub use sparse::Sparse;

/// Bytes that one program command writes at most.
pub const PAGE: u32 = 256;
/// Bytes of the smallest erase.
pub const SUBSECTOR: u32 = 4 << 10;
/// Bytes of the larger erase.
pub const SECTOR: u32 = 64 << 10;
/// An erase is cut off after one of so many parts of its time.
pub const ERASE_STEPS: u32 = 8;

/// A flash of 256 Mbit (MT25QL256).
pub const MBIT_256: [u8; 3] = [0x20, 0xBA, 0x19];
/// A flash of 256 MByte (MT25QL02G).
pub const MBYTE_256: [u8; 3] = [0x20, 0xBA, 0x22];
/// A flash of 512 KiB: for boards that hold it in RAM, and for tests that look at every byte.
pub const KBYTE_512: [u8; 3] = [0x20, 0xBA, 0x13];

/// Returns the output of a future over simulated flash, which never waits, so that polling it once is enough.
/// `None` for one that waits for something else.
pub fn finish<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(answer) => Some(answer),
        Poll::Pending => None,
    }
}

/// Durations of operations, ns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timing {
    /// A command and its address.
    pub command: u64,
    /// A byte on the bus.
    pub byte: u64,
    /// A program, whatever its length.
    pub program: u64,
    /// An erase of a subsector.
    pub subsector: u64,
    /// An erase of a sector.
    pub sector: u64,
}

impl Timing {
    /// Typical times of the MT25QL family (data sheet, AC characteristics) on a line of 25 MHz.
    pub const TYPICAL: Self =
        Self { command: 1_600, byte: 320, program: 120_000, subsector: 50_000_000, sector: 150_000_000 };
}

/// Memory that holds the bytes.
pub trait Memory {
    /// Reads from `address` on; what was never written is all ones.
    fn read(&self, address: u32, bytes: &mut [u8]);
    /// Sets one byte.
    fn set(&mut self, address: u32, byte: u8);
    /// Sets a range to all ones.
    fn clear(&mut self, from: u32, to: u32);
}

impl Memory for &mut [u8] {
    fn read(&self, address: u32, bytes: &mut [u8]) {
        if let Some(held) = self.get(address as usize..address as usize + bytes.len()) {
            bytes.copy_from_slice(held);
        }
    }
    fn set(&mut self, address: u32, byte: u8) {
        if let Some(held) = self.get_mut(address as usize) {
            *held = byte;
        }
    }
    fn clear(&mut self, from: u32, to: u32) {
        if let Some(held) = self.get_mut(from as usize..to as usize) {
            held.fill(0xFF);
        }
    }
}

/// State of the byte, or of the part of an erase, during which the power failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tear {
    /// It is as it was before.
    Nothing,
    /// Some of the bits have changed, here and in what was still to come of the page or the subsectors.
    Partial,
    /// Random bits have changed, in the same places: bits that nobody wanted to change, too.
    Garbage,
}

/// Reason why an operation failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// The power is gone, until [`Flash::restore_power`].
    PowerLost,
    /// Nobody answers.
    Absent,
    /// Beyond the end, or not on the borders of subsectors.
    Range,
}

/// The chip.
#[derive(Clone, Debug)]
pub struct Flash<M> {
    memory: M,
    identification: [u8; 3],
    timing: Timing,
    busy: u64,
    absent: bool,
    steps: u64,
    cut: Option<(u64, Tear)>,
    off: bool,
    random: Random,
    counts: Counts,
}

/// Operations since the chip was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Program commands.
    pub programs: u64,
    /// Erases of subsectors, those of a sector counted as 16.
    pub erases: u64,
    /// Bits that a program was asked to set, which it cannot.
    pub lost_bits: u64,
}

impl<M: Memory> Flash<M> {
    /// A chip with this JEDEC identification around some memory, which is as large.
    pub const fn new(identification: [u8; 3], memory: M, seed: u64) -> Self {
        Self {
            memory,
            identification,
            timing: Timing::TYPICAL,
            busy: 0,
            absent: false,
            steps: 0,
            cut: None,
            off: false,
            random: Random::new(seed),
            counts: Counts { programs: 0, erases: 0, lost_bits: 0 },
        }
    }

    /// JEDEC identification: all ones if nobody answers.
    pub const fn identification(&self) -> [u8; 3] {
        if self.absent { [0xFF; 3] } else { self.identification }
    }

    /// A chip as it comes from its maker: all ones.
    pub fn clear(&mut self) {
        self.memory.clear(0, layout::capacity(self.identification).unwrap_or(0));
    }

    /// Time that operations have taken since the last call, ns.
    pub const fn take_busy(&mut self) -> u64 {
        core::mem::replace(&mut self.busy, 0)
    }

    /// Takes the chip off its board, or puts it back.
    pub const fn set_absent(&mut self, absent: bool) {
        self.absent = absent;
    }

    /// Lets the power fail in step `step` from now: each byte of a program is one, and each eighth of an
    /// erase.
    pub const fn cut_after(&mut self, steps: u64, tear: Tear) {
        self.cut = Some((self.steps + steps, tear));
    }

    /// The power is back.
    pub const fn restore_power(&mut self) {
        (self.off, self.cut) = (false, None);
    }

    /// Returns whether the cut has happened.
    pub const fn is_off(&self) -> bool {
        self.off
    }

    /// Steps since the chip was made: the places where a cut can strike.
    pub const fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns the counts of its operations.
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    /// The memory, to look at.
    pub const fn memory(&self) -> &M {
        &self.memory
    }

    /// The memory, to keep.
    pub fn into_memory(self) -> M {
        self.memory
    }

    /// Turns one bit over, 0..=7 of the byte at `address`.
    pub fn flip(&mut self, address: u32, bit: u8) {
        let byte = self.byte(address) ^ 1 << bit;
        self.memory.set(address, byte);
    }

    fn byte(&self, address: u32) -> u8 {
        let mut byte = [0xFF];
        self.memory.read(address, &mut byte);
        let [byte] = byte;
        byte
    }

    fn check(&self, from: u32, length: usize) -> Result<(), FlashError> {
        let end = u64::from(from) + length as u64;
        match (self.off, layout::capacity(self.identification())) {
            (true, _) => Err(FlashError::PowerLost),
            (false, None) => Err(FlashError::Absent),
            (false, Some(capacity)) if end > u64::from(capacity) => Err(FlashError::Range),
            _ => Ok(()),
        }
    }

    /// Time goes on by one step; whether the power fails in it, and what that leaves.
    fn step(&mut self) -> Option<Tear> {
        let struck = self.cut.filter(|(at, _)| *at == self.steps);
        self.steps += 1;
        self.off |= struck.is_some();
        struck.map(|(_, tear)| tear)
    }

    fn program(&mut self, address: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.counts.programs += 1;
        self.busy += self.timing.command + self.timing.byte * bytes.len() as u64 + self.timing.program;
        let mut torn = None;
        for (at, wanted) in (address..).zip(bytes) {
            torn = torn.or_else(|| self.step());
            let old = self.byte(at);
            let new = match torn {
                None => old & wanted,
                Some(Tear::Nothing) => break,
                Some(Tear::Partial) => old & (wanted | self.random.bits() as u8),
                Some(Tear::Garbage) => old & self.random.bits() as u8,
            };
            self.counts.lost_bits += u64::from((wanted & !old).count_ones());
            self.memory.set(at, new);
        }
        if torn.is_some() { Err(FlashError::PowerLost) } else { Ok(()) }
    }

    fn erase_piece(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        let part = (to - from) / ERASE_STEPS;
        self.counts.erases += u64::from((to - from) / SUBSECTOR);
        self.busy += self.timing.command;
        self.busy += if to - from == SECTOR { self.timing.sector } else { self.timing.subsector };
        for number in 0..ERASE_STEPS {
            let at = from + number * part;
            match self.step() {
                None => self.memory.clear(at, at + part),
                Some(Tear::Nothing) => return Err(FlashError::PowerLost),
                Some(tear) => {
                    for address in at..to {
                        let random = self.random.bits() as u8;
                        let old = if tear == Tear::Partial { self.byte(address) } else { 0 };
                        self.memory.set(address, old | random);
                    }
                    return Err(FlashError::PowerLost);
                }
            }
        }
        Ok(())
    }
}

impl<M> ErrorType for Flash<M> {
    type Error = FlashError;
}

impl<M: Memory> ReadNorFlash for Flash<M> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        self.check(offset, bytes.len())?;
        self.busy += self.timing.command + self.timing.byte * bytes.len() as u64;
        self.memory.read(offset, bytes);
        Ok(())
    }

    fn capacity(&self) -> usize {
        layout::capacity(self.identification()).map_or(0, |bytes| bytes as usize)
    }
}

impl<M: Memory> NorFlash for Flash<M> {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SUBSECTOR as usize;

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.check(offset, bytes.len())?;
        let mut at = offset;
        let mut rest = bytes;
        while !rest.is_empty() {
            let room = (PAGE - at % PAGE) as usize;
            let (now, later) = rest.split_at(room.min(rest.len()));
            self.program(at, now)?;
            at += now.len() as u32;
            rest = later;
        }
        Ok(())
    }

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.check(from, to.saturating_sub(from) as usize)?;
        if !from.is_multiple_of(SUBSECTOR) || !to.is_multiple_of(SUBSECTOR) || from > to {
            return Err(FlashError::Range);
        }
        let mut at = from;
        while at < to {
            let whole = at.is_multiple_of(SECTOR) && to - at >= SECTOR;
            let end = at + if whole { SECTOR } else { SUBSECTOR };
            self.erase_piece(at, end)?;
            at = end;
        }
        Ok(())
    }
}

impl<M: Memory> MultiwriteNorFlash for Flash<M> {}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Range => NorFlashErrorKind::OutOfBounds,
            _ => NorFlashErrorKind::Other,
        }
    }
}

impl fmt::Display for FlashError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PowerLost => "the power failed",
            Self::Absent => "no flash answers",
            Self::Range => "beyond the end of the flash, or not a whole number of subsectors",
        })
    }
}

impl core::error::Error for FlashError {}
