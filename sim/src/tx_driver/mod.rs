//! TX-Drivers on a bus and a shaft: the real device around simulated sensors, memory and CAN controller.
//!
//! ```text
//!  shaft ──> sensors, encoder ──> TxDriver <──> controller (one mailbox) <──> bus
//!                                    └──> memory, restart
//! ```
//!
//! All of them sample at the same instants, every [`STEP_NS`], and look at their controllers as often.

mod config;
mod device;
#[cfg(feature = "transcripts")]
mod notes;

pub use config::{AddError, TxDriverConfig};
pub use device::Device;

use crate::can::Bus;
use crate::random::Random;
use crate::sensor::Shaft;
use alloc::vec::Vec;

/// Samples a second of a channel, Hz: four to a period of the highest edge frequency (Table 9).
pub const SAMPLE_RATE: u32 = 40_000;
/// From one sample to the next, ns.
pub const STEP_NS: u64 = 1_000_000_000 / SAMPLE_RATE as u64;
/// Firmware version that the simulated device answers under 2100h.
pub const FIRMWARE: u16 = 0x0100;

/// All TX-Drivers of a bus.
#[derive(Clone, Debug)]
pub struct TxDrivers {
    devices: Vec<Device>,
    seed: u64,
    /// Time up to which they have run, and the shaft at that time.
    now_ns: u64,
    shaft: Shaft,
}

impl TxDrivers {
    /// None yet. `seed` is that of all their noise.
    pub const fn new(seed: u64) -> Self {
        Self { devices: Vec::new(), seed, now_ns: 0, shaft: Shaft { turns: 0.0, speed: 0.0 } }
    }

    /// Powers one up on a place of its own on `bus` at `now_ns`.
    ///
    /// # Errors
    /// A sensor that cannot be, or no place on the bus.
    pub fn add<const NODES: usize, const QUEUE: usize>(
        &mut self,
        config: &TxDriverConfig,
        bus: &mut Bus<NODES, QUEUE>,
        now_ns: u64,
        shaft: Shaft,
    ) -> Result<usize, AddError> {
        let place = self.devices.len();
        // Each has noise of its own, whatever the others do.
        let noise = Random::new(self.seed ^ (place as u64 + 1) << 32);
        self.devices.push(Device::new(config, bus, noise)?);
        if place == 0 {
            (self.now_ns, self.shaft) = (now_ns, shaft);
        }
        Ok(place)
    }

    /// Returns whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.devices.is_empty()
    }

    /// In the order in which they were added.
    pub fn devices(&self) -> &[Device] {
        &self.devices
    }

    /// Returns the devices in the same order, to change what their sensors watch.
    pub fn devices_mut(&mut self) -> &mut [Device] {
        &mut self.devices
    }

    /// Lets them run to `now_ns`, where the shaft is at `shaft`; the bus is settled up to their last step. In
    /// between the shaft turns evenly.
    pub fn run<const NODES: usize, const QUEUE: usize>(
        &mut self,
        bus: &mut Bus<NODES, QUEUE>,
        now_ns: u64,
        shaft: Shaft,
    ) {
        let (begin, before) = (self.now_ns, self.shaft);
        let mut instant = (begin / STEP_NS + 1) * STEP_NS;
        while instant <= now_ns {
            bus.advance(instant);
            let part = (instant - begin) as f64 / (now_ns - begin) as f64;
            let between = |from: f64, to: f64| from + (to - from) * part;
            let shaft = Shaft {
                turns: between(before.turns, shaft.turns),
                speed: between(before.speed, shaft.speed),
            };
            for device in &mut self.devices {
                device.step(bus, instant, &shaft);
            }
            instant += STEP_NS;
        }
        (self.now_ns, self.shaft) = (now_ns, shaft);
    }
}
