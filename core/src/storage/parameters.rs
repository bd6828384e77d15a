//! The stored form of a parameter set: pairs of number and value, so that firmware with another dictionary
//! finds the parameters that it knows.
//!
//! ```text
//!  format u16 | firmware release u16 | number u16, value i32 | number u16, value i32 | ...       big endian
//! ```

use crate::dictionary::{Category, Dictionary, Parameter, Parameters, number};
use serde::{Deserialize, Serialize};

/// The format that is written, and the newest one that is understood. It rises if head or pairs get another
/// form. A new parameter is one more number and raises nothing.
pub(super) const FORMAT: u16 = 1;
const HEAD: usize = 4;
const PAIR: usize = 6;

/// Room for parameters of newer firmware, which are skipped when an older one is put back.
const NEWER: usize = 8;

/// Room for any set of this dictionary.
pub(super) const BODY_MAX: usize = HEAD + PAIR * (Dictionary::STORED_COUNT + NEWER);

/// A part of the parameters; each is stored by a command of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Part {
    /// The part that parameter 256 stores: everything but the board's own data.
    Set,
    /// The part that parameter 257 stores: device number and calibration (category 02).
    Once,
}

/// A stored value does not fit its parameter any more, or newer firmware has written the set in another form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unfit;

impl Part {
    /// Returns whether a parameter belongs to this part. Commands, and parameters that the drive itself
    /// writes, belong to none.
    pub fn contains(self, row: &Parameter) -> bool {
        let once = row.number == number::DEVICE_NUMBER || row.category == Category::Calibration;
        row.is_stored() && once == (self == Self::Once)
    }

    /// Writes the part's values; returns the number of bytes.
    pub(super) fn encode(self, parameters: &Parameters, body: &mut [u8]) -> usize {
        let release = parameters.raw(number::SOFTWARE_RELEASE) as u16;
        let (head, mut rest) = body.split_at_mut(HEAD.min(body.len()));
        if let [a, b, c, d] = head {
            ([*a, *b], [*c, *d]) = (FORMAT.to_be_bytes(), release.to_be_bytes());
        }
        let mut length = HEAD;
        for (row, raw) in parameters.iter().filter(|(row, _)| self.contains(row)) {
            let Some((pair, after)) = rest.split_first_chunk_mut::<PAIR>() else { break };
            let [a, b, c, d, e, f] = pair;
            ([*a, *b], [*c, *d, *e, *f]) = (row.number.to_be_bytes(), raw.to_be_bytes());
            length += PAIR;
            rest = after;
        }
        length
    }

    /// Takes over the stored values. Numbers that this firmware does not know are skipped, and parameters
    /// that are not stored keep their value. A value out of range is not taken, and the result is an error.
    pub(super) fn decode(self, body: &[u8], parameters: &mut Parameters) -> Result<(), Unfit> {
        let Some(([f0, f1, _, _], pairs)) = body.split_first_chunk::<HEAD>() else { return Err(Unfit) };
        if u16::from_be_bytes([*f0, *f1]) > FORMAT {
            return Err(Unfit);
        }
        let (pairs, rest) = pairs.as_chunks::<PAIR>();
        let mut fits = rest.is_empty();
        for [a, b, c, d, e, f] in pairs {
            let number = u16::from_be_bytes([*a, *b]);
            let known = Dictionary::row(number).is_some_and(|row| self.contains(row));
            if known {
                fits &= parameters.set(number, i32::from_be_bytes([*c, *d, *e, *f])).is_ok();
            }
        }
        if fits { Ok(()) } else { Err(Unfit) }
    }
}
