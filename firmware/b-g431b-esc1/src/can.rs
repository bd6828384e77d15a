//! FDCAN: bit timing and the elements of its message memory (RM0440, sections 44.3.4 and 44.3.6).

use narx_core::bus::{BusState, ErrorState, Frame, Id};

/// The crystal: the controller runs from it, past the PLL.
pub const CLOCK_HZ: u32 = 8_000_000;
/// The bus, bit/s (Table 2 of the drive's specification).
pub const BIT_RATE: u32 = 500_000;

/// A bit in quanta of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BitTiming {
    /// Clocks of a quantum.
    pub prescaler: u16,
    /// Quanta from the first one to the sampling point.
    pub segment_1: u8,
    /// Quanta behind it.
    pub segment_2: u8,
    /// Quanta by which a bit may be made longer or shorter.
    pub jump: u8,
}

impl BitTiming {
    /// An exact division of `clock` into bits of 8 to 40 quanta, sampled at 87.5 % or the next place before
    /// it (CiA 301); the finest that there is. `None` where none is exact.
    pub const fn of(clock: u32, bit_rate: u32) -> Option<Self> {
        let mut prescaler = 1;
        while prescaler <= 512 && bit_rate > 0 {
            let quanta = clock / bit_rate / prescaler;
            if quanta >= 8 && quanta <= 40 && quanta * prescaler * bit_rate == clock {
                let segment_2 = quanta.div_ceil(8) as u8;
                return Some(Self {
                    prescaler: prescaler as u16,
                    segment_1: quanta as u8 - 1 - segment_2,
                    segment_2,
                    jump: segment_2,
                });
            }
            prescaler += 1;
        }
        None
    }

    /// The register NBTP.
    pub const fn register(&self) -> u32 {
        (self.jump as u32 - 1) << 25
            | (self.prescaler as u32 - 1) << 16
            | (self.segment_1 as u32 - 1) << 8
            | (self.segment_2 as u32 - 1)
    }
}

const EXTENDED: u32 = 1 << 30;
const REMOTE: u32 = 1 << 29;
const STANDARD_SHIFT: u32 = 18;
const DLC_SHIFT: u32 = 16;

/// The first four words of a transmit buffer.
pub fn encode(frame: &Frame) -> [u32; 4] {
    let id = frame.id();
    let id = if id.is_extended() { id.raw() | EXTENDED } else { id.raw() << STANDARD_SHIFT };
    let remote = if frame.is_remote() { REMOTE } else { 0 };
    let mut data = [0; 8];
    if let Some(place) = data.get_mut(..frame.payload().len()) {
        place.copy_from_slice(frame.payload());
    }
    let [a, b, c, d, e, f, g, h] = data;
    [
        id | remote,
        u32::from(frame.dlc()) << DLC_SHIFT,
        u32::from_le_bytes([a, b, c, d]),
        u32::from_le_bytes([e, f, g, h]),
    ]
}

/// The first four words of a received element. A length code above 8 counts as 8 (ISO 11898-1).
pub fn decode(words: [u32; 4]) -> Option<Frame> {
    let [head, length, low, high] = words;
    let id = if head & EXTENDED != 0 {
        Id::extended(head & 0x1FFF_FFFF)
    } else {
        Id::standard((head >> STANDARD_SHIFT & 0x7FF) as u16)
    }?;
    let dlc = (length >> DLC_SHIFT & 0xF).min(8) as u8;
    if head & REMOTE != 0 {
        return Frame::remote(id, dlc);
    }
    let ([a, b, c, d], [e, f, g, h]) = (low.to_le_bytes(), high.to_le_bytes());
    Frame::data(id, [a, b, c, d, e, f, g, h].get(..usize::from(dlc))?)
}

/// Decodes the state of the controller from the registers PSR and ECR.
pub const fn bus_state(psr: u32, ecr: u32) -> BusState {
    const PASSIVE: u32 = 1 << 5;
    const BUS_OFF: u32 = 1 << 7;
    // At 128 the receive counter stops, and a bit tells so.
    const RECEIVE_PASSIVE: u32 = 1 << 15;
    let error = if psr & BUS_OFF != 0 {
        ErrorState::BusOff
    } else if psr & PASSIVE != 0 {
        ErrorState::Passive
    } else {
        ErrorState::Active
    };
    let receive = ecr >> 8 & 0x7F;
    BusState {
        error,
        transmit_errors: (ecr & 0xFF) as u16,
        receive_errors: if ecr & RECEIVE_PASSIVE != 0 { 128 } else { receive as u16 },
    }
}
