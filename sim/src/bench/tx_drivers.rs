//! TX-Drivers on the bench's bus, beside its shaft.

use super::Bench;
use crate::sensor::Shaft;
use crate::tx_driver::{AddError, Device, TxDriverConfig};
use core::f64::consts::TAU;

impl Bench {
    /// Powers up a TX-Driver on the drive's bus and shaft; answers its place in [`Self::tx_drivers`]. A bus
    /// has room for 127. What it measures is no part of a recording: the drive does not know of it.
    ///
    /// # Errors
    /// A sensor that cannot be, or 127 drivers already.
    pub fn add_tx_driver(&mut self, config: &TxDriverConfig) -> Result<usize, AddError> {
        let (now_ns, shaft) = (self.now_ns(), self.shaft());
        self.tx_drivers.add(config, &mut self.bus, now_ns, shaft)
    }

    /// The TX-Drivers in the order in which they were added.
    pub fn tx_drivers(&self) -> &[Device] {
        self.tx_drivers.devices()
    }

    /// The TX-Drivers, to change what their sensors watch.
    pub fn tx_drivers_mut(&mut self) -> &mut [Device] {
        self.tx_drivers.devices_mut()
    }

    /// Present position and speed of the shaft.
    pub fn shaft(&self) -> Shaft {
        let seen = self.plant.observe();
        Shaft { turns: seen.angle / TAU, speed: seen.speed }
    }

    /// Lets the TX-Drivers come to the end of this tick.
    #[inline]
    pub(super) fn run_tx_drivers(&mut self, now_ns: u64) {
        if !self.tx_drivers.is_empty() {
            let shaft = self.shaft();
            self.tx_drivers.run(&mut self.bus, now_ns, shaft);
        }
    }
}
