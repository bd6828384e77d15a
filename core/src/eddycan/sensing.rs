//! Samples to the readings in PDOs and the switching outputs.

use super::Variant;
use super::configuration::Configuration;
use super::encoder::Encoder;
use super::filter::Filter;
use crate::bus::eddycan::{Channels, Position, Reading};
use serde::{Deserialize, Serialize};

/// Samples of the board at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sample {
    /// Position of each channel; with one channel the second is ignored.
    pub positions: [Position; 2],
    /// The encoder's counter, four counts to a period, running free.
    pub counter: u16,
}

/// Filters, comparators and encoder.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sensing {
    filters: [Filter; 2],
    encoder: Encoder,
    /// Filtered positions; `None` before the first sample.
    positions: Option<[Position; 2]>,
    outputs: [bool; 2],
}

impl Sensing {
    pub(super) fn new(variant: &Variant, configuration: &Configuration) -> Self {
        let mut sensing = Self {
            filters: [Filter::new(); 2],
            encoder: Encoder::default(),
            positions: None,
            outputs: [false; 2],
        };
        sensing.configure(variant, configuration);
        sensing
    }

    /// Takes over the filters of a configuration; everything else of it is looked up when it is needed.
    pub(super) fn configure(&mut self, variant: &Variant, configuration: &Configuration) {
        for (filter, edge) in self.filters.iter_mut().zip(configuration.edges()) {
            filter.set_edge(edge, variant.sample_rate);
        }
    }

    pub(super) fn take(&mut self, sample: Sample, variant: &Variant, configuration: &Configuration) {
        let [first, second] = sample.positions.map(Position::raw);
        let [filter1, filter2] = &mut self.filters;
        let first = Position::from_raw(filter1.step(first));
        let (second, compared) = match variant.channels {
            // Both comparators are the first channel's: a low and a high threshold.
            Channels::Single => (Position::default(), [first, first]),
            Channels::Dual => {
                let second = Position::from_raw(filter2.step(second));
                (second, [first, second])
            }
        };
        self.positions = Some([first, second]);
        self.encoder.count(sample.counter);
        let [range1, range2] = variant.ranges;
        let range2 = if variant.channels == Channels::Single { range1 } else { range2 };
        let [fraction1, fraction2] = configuration.comparators();
        let [compared1, compared2] = compared;
        self.outputs = [range1.is_above(compared1, fraction1), range2.is_above(compared2, fraction2)];
    }

    pub(super) const fn reset_encoder(&mut self) {
        self.encoder.reset();
    }

    pub(super) const fn outputs(&self) -> [bool; 2] {
        self.outputs
    }

    /// Reading to send; `None` before the first sample.
    pub(super) fn reading(&self, configuration: &Configuration) -> Option<Reading> {
        let encoder = self.encoder.value(configuration.encoder());
        self.positions.map(|positions| Reading { positions, encoder })
    }
}
