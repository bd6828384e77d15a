//! The incremental encoder: counts of a free-running counter, added up and shown in 16 bits.

use super::configuration::EncoderSetup;

/// Position of the encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Encoder {
    /// The counter as it was last read; `None` before the first reading.
    last: Option<u16>,
    /// Counts since power-up or the last reset, in the counter's own direction.
    gone: i64,
}

impl Encoder {
    /// Takes the counter. Up to half of its 65536 counts may lie between two readings.
    pub(super) fn count(&mut self, counter: u16) {
        let before = self.last.replace(counter).unwrap_or(counter);
        let moved = counter.wrapping_sub(before) as i16;
        self.gone = self.gone.saturating_add(moved.into());
    }

    /// Makes the present position 0.
    pub(super) const fn reset(&mut self) {
        self.gone = 0;
    }

    /// Value for a PDO: of a rotary encoder the position in the revolution, of a linear one the distance,
    /// limited to 16 bits. Counting goes on beyond the limits, so the value is right again when the encoder
    /// comes back.
    pub(super) fn value(&self, setup: EncoderSetup) -> u16 {
        let gone = if setup.reverse { self.gone.saturating_neg() } else { self.gone };
        match setup.counts_per_revolution {
            Some(counts) => gone.rem_euclid(i64::from(counts).max(1)) as u16,
            None => gone.clamp(i16::MIN.into(), i16::MAX.into()) as i16 as u16,
        }
    }
}
