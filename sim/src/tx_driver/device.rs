//! One TX-Driver with everything around it: what a board's firmware would do, and the board.

use super::config::{AddError, TxDriverConfig};
use super::{FIRMWARE, SAMPLE_RATE};
use crate::can::{Bus, NodeIndex};
use crate::random::Random;
use crate::sensor::{EddyCurrent, Encoder, Shaft};
use narx_core::eddycan::{Configuration, Sample, TxDriver, Variant};
#[cfg(feature = "transcripts")]
use {super::notes::Notes, alloc::vec::Vec};

/// Frames in its controller. So what it sends is never older than one frame, and a position that waits in the
/// device is replaced by the next.
const MAILBOXES: usize = 1;

/// A TX-Driver on a bus.
#[derive(Clone, Debug)]
pub struct Device {
    driver: TxDriver,
    variant: Variant,
    /// Configuration in its memory, from which a restart begins. Writing it takes no time here.
    stored: Configuration,
    sensors: [EddyCurrent; 2],
    encoder: Option<Encoder>,
    noise: Random,
    place: NodeIndex,
    #[cfg(feature = "transcripts")]
    notes: Option<Notes>,
}

/// Writes down a call, where that is wanted. Nothing of it is compiled into a bench without transcripts.
macro_rules! note {
    ($self:ident, $($call:tt)*) => {
        #[cfg(feature = "transcripts")]
        if let Some(notes) = &mut $self.notes {
            notes.$($call)*;
        }
    };
}

impl Device {
    /// Powers up.
    pub(super) fn new<const NODES: usize, const QUEUE: usize>(
        config: &TxDriverConfig,
        bus: &mut Bus<NODES, QUEUE>,
        noise: Random,
    ) -> Result<Self, AddError> {
        let [first, second] = config.sensors.map(EddyCurrent::new);
        let sensors = [first?, second?];
        let ranges = sensors.map(|sensor| sensor.measuring_range());
        let place = bus.attach().ok_or(AddError::NoPlace)?;
        let stored = config.configuration;
        let variant =
            Variant { channels: config.channels, ranges, sample_rate: SAMPLE_RATE, firmware: FIRMWARE };
        let driver = TxDriver::new(variant, stored);
        bus.set_bitrate(place, driver.bitrate().bits_per_second());
        Ok(Self {
            driver,
            variant,
            stored,
            sensors,
            encoder: config.encoder,
            noise,
            place,
            #[cfg(feature = "transcripts")]
            notes: None,
        })
    }

    /// The device itself.
    pub const fn driver(&self) -> &TxDriver {
        &self.driver
    }

    /// Its place on the bus.
    pub const fn place(&self) -> NodeIndex {
        self.place
    }

    /// Its sensors: what they truly see.
    pub const fn sensors(&self) -> &[EddyCurrent; 2] {
        &self.sensors
    }

    /// Puts other sensors, or the same ones before other targets, in the place of its sensors. The device
    /// goes on with the ranges that it was powered up with.
    pub const fn set_sensors(&mut self, sensors: [EddyCurrent; 2]) {
        self.sensors = sensors;
    }

    /// Powers it up anew from what it has stored, and writes down what it is told and asked from then on:
    /// [`Device::transcript`].
    #[cfg(feature = "transcripts")]
    pub fn begin_transcript(&mut self, label: &str) {
        self.driver = TxDriver::new(self.variant, self.stored);
        self.notes = Notes::new(self.variant, self.stored, label);
    }

    /// Transcript of its inputs and queries since it last started, to be [run
    /// again](narx_core::recording::transcript); empty without [`Device::begin_transcript`].
    #[cfg(feature = "transcripts")]
    pub fn transcript(&self) -> Vec<u8> {
        self.notes.as_ref().map_or_else(Vec::new, |notes| notes.finish(&self.driver))
    }

    /// One pass of its loop.
    pub(super) fn step<const NODES: usize, const QUEUE: usize>(
        &mut self,
        bus: &mut Bus<NODES, QUEUE>,
        now_ns: u64,
        shaft: &Shaft,
    ) {
        let state = bus.state(self.place);
        if state.is_off() {
            bus.discard(self.place);
        }
        note!(self, bus_state(state));
        self.driver.handle_bus_state(state);
        let sample = self.sample(shaft);
        note!(self, sample(sample));
        self.driver.handle_sample(sample);
        while let Some(received) = bus.receive(self.place) {
            note!(self, frame(&received.frame, received.time_ns / 1000));
            self.driver.handle_frame(&received.frame, received.time_ns / 1000);
        }
        note!(self, poll(now_ns / 1000));
        self.driver.poll(now_ns / 1000);
        note!(self, outputs(self.driver.outputs()));
        if let Some(configuration) = self.driver.poll_store() {
            note!(self, stored(configuration));
            self.stored = configuration;
            self.driver.handle_store(true);
        }
        if self.driver.take_reset() {
            note!(self, reset(self.variant, self.stored));
            self.driver = TxDriver::new(self.variant, self.stored);
            bus.discard(self.place);
            bus.set_bitrate(self.place, self.driver.bitrate().bits_per_second());
        }
        while bus.queued(self.place) < MAILBOXES
            && let Some(frame) = self.driver.poll_frame()
        {
            note!(self, sent(frame));
            // Room was just seen.
            let _ = bus.send(self.place, frame, now_ns);
        }
    }

    fn sample(&mut self, shaft: &Shaft) -> Sample {
        let [noise1, noise2] = self.noise.gaussians();
        let [first, second] = self.sensors;
        Sample {
            positions: [first.sample(shaft, noise1), second.sample(shaft, noise2)],
            counter: self.encoder.map_or(0, |encoder| encoder.counter(shaft)),
        }
    }
}
