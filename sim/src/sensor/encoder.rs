//! The incremental encoder: two tracks a quarter of a period apart, hence four counts to a period, and no
//! index (the connector has no line for one).

use super::Shaft;

/// An incremental encoder, by what moves its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Encoder {
    /// On the shaft.
    Rotary {
        /// Counts of a revolution, four to a period.
        counts: u16,
    },
    /// Along the nut of a screw on the shaft.
    Linear {
        /// Way of the nut, mm per revolution.
        lead: f64,
        /// Length of a count, nm.
        resolution: u16,
    },
}

impl Encoder {
    /// The free-running counter at an instant, low 16 bits: up while the shaft turns forward.
    pub fn counter(&self, shaft: &Shaft) -> u16 {
        let counts = match *self {
            Self::Rotary { counts } => shaft.turns * f64::from(counts),
            Self::Linear { lead, resolution } => shaft.turns * lead * 1e6 / f64::from(resolution.max(1)),
        };
        // A count begins where its edge is: below it is the one before, on either side of 0.
        libm::floor(counts) as i64 as u16
    }
}
