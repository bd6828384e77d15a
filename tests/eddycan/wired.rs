//! TX-Drivers on a bus with a host, and a shaft that turns evenly: the bench without its drive, at any
//! bitrate.

use crate::bench::{configured, node};
use narx_core::bus::Frame;
use narx_core::bus::eddycan::{Bitrate, FromNode, Layout, NmtCommand, Target, ToNode};
use narx_core::eddycan::Entry;
use narx_sim::can::{Bus, NodeIndex, Received};
use narx_sim::sensor::Shaft;
use narx_sim::tx_driver::{Device, TxDriverConfig, TxDrivers};

/// Duration of a tick of the bench, ns.
const TICK: u64 = 100_000;

pub(crate) struct Wired {
    pub(crate) bus: Bus<128, 64>,
    pub(crate) drivers: TxDrivers,
    pub(crate) host: NodeIndex,
    pub(crate) now: u64,
    pub(crate) shaft: Shaft,
    /// Speed of the shaft, revolutions per second.
    pub(crate) rate: f64,
}

/// Configuration of a driver: factory values, except these.
pub(crate) fn driver(id: u8, values: &[(Entry, u32)]) -> TxDriverConfig {
    let values: Vec<(Entry, u32)> = values.iter().copied().chain([(Entry::NodeId, id.into())]).collect();
    TxDriverConfig { configuration: configured(&values), ..TxDriverConfig::new(node(id)) }
}

impl Wired {
    pub(crate) fn new(bitrate: Bitrate) -> Self {
        let mut bus = Bus::new(bitrate.bits_per_second());
        let host = bus.attach().unwrap();
        Self { bus, drivers: TxDrivers::new(1), host, now: 0, shaft: Shaft::default(), rate: 0.0 }
    }

    pub(crate) fn add(&mut self, config: &TxDriverConfig) {
        self.drivers.add(config, &mut self.bus, self.now, self.shaft).unwrap();
    }

    pub(crate) fn device(&self, place: usize) -> &Device {
        &self.drivers.devices()[place]
    }

    pub(crate) fn send(&mut self, message: ToNode) {
        self.bus.send(self.host, message.encode(), self.now).unwrap();
    }

    pub(crate) fn command(&mut self, command: NmtCommand) {
        self.send(ToNode::Nmt { command, target: Target::All });
    }

    /// Lets these many milliseconds pass; returns the frames that the host receives.
    pub(crate) fn run(&mut self, milliseconds: u64) -> Vec<Received> {
        (0..milliseconds * 1_000_000 / TICK).flat_map(|_| self.tick()).collect()
    }

    /// Lets one tick of the bench pass; returns the frames that the host receives.
    pub(crate) fn tick(&mut self) -> Vec<Received> {
        self.now += TICK;
        self.shaft.turns += self.rate * TICK as f64 * 1e-9;
        self.shaft.speed = self.rate * std::f64::consts::TAU;
        self.drivers.run(&mut self.bus, self.now, self.shaft);
        self.bus.advance(self.now);
        std::iter::from_fn(|| self.bus.receive(self.host)).collect()
    }
}

/// Node-id and message of a TX-Driver's frame.
pub(crate) fn read(frame: &Frame, layout: Layout) -> Option<(u8, FromNode)> {
    let (node, message) = FromNode::decode(frame, layout).ok()?;
    Some((node.raw(), message))
}
