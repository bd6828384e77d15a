//! Tests of a master that configures a driver over the simulated bus and reads the shaft's motion from its
//! sensors and encoder.

use crate::bench::{mm, node};
use crate::wired::{Wired, driver};
use narx_core::bus::eddycan::{Bitrate, Channels, Layout, NmtCommand, NmtState};
use narx_core::eddycan::Entry;
use narx_core::master::eddycan::{Config, Request, TxMaster};
use narx_sim::sensor::{EddyCurrentConfig, Encoder, Target};
use narx_sim::tx_driver::TxDriverConfig;

/// The bus, with the master in the host's place.
struct Mastered {
    wired: Wired,
    master: TxMaster,
}

impl Mastered {
    fn new(config: &TxDriverConfig) -> Self {
        let mut wired = Wired::new(Bitrate::K500);
        wired.add(config);
        let layout = Layout { channels: config.channels, encoder: false };
        let master = TxMaster::new(Config::new(config.configuration.node(), layout));
        let mut mastered = Self { wired, master };
        mastered.run(5);
        mastered
    }

    fn run(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds {
            while let Some(frame) = self.master.poll_frame(self.wired.now / 1000) {
                self.wired.bus.send(self.wired.host, frame, self.wired.now).unwrap();
            }
            for received in self.wired.run(1) {
                self.master.handle_frame(&received.frame, received.time_ns / 1000);
            }
        }
    }

    fn write(&mut self, values: &[(Entry, u32)]) {
        for &(entry, value) in values {
            self.master.request(Request::Write(entry, value)).unwrap();
            self.run(5);
            assert_eq!(self.master.poll_answer().unwrap().result, Ok(value));
        }
    }

    fn start(&mut self) {
        self.master.command(NmtCommand::Start).unwrap();
        self.run(3);
        assert_eq!(self.wired.device(0).driver().state(), NmtState::Operational);
    }
}

/// Two channels and a rotary encoder in one PDO give both distances and the angle of the shaft: forward, in
/// reverse, and with the count reversed.
#[test]
fn distances_and_angle_of_a_turning_shaft() {
    let sensors = [1.0, 0.5].map(|rest| EddyCurrentConfig::new(4.0, Target::nut(rest, 0.25)));
    let encoder = Some(Encoder::Rotary { counts: 4096 });
    let config = TxDriverConfig { channels: Channels::Dual, sensors, encoder, ..driver(3, &[]) };
    for (rate, register, sign) in [(1.25, 2, 1.0), (-0.5, 2, 1.0), (1.25, 6, -1.0)] {
        let mut mastered = Mastered::new(&config);
        let values = [(Entry::CanConfig, 2), (Entry::BasicConfig, register), (Entry::UpdateTime, 1)];
        mastered.write(&values);
        mastered.start();
        mastered.wired.rate = rate;
        mastered.run(2000);
        let (reading, _, time) = mastered.master.reading().unwrap();
        // Between the sampling step and the end of the frame lie the frame and at most one step.
        let age = (mastered.wired.now / 1000 - time) as f64 * 1e-6 + 0.3e-3;
        let turns = mastered.wired.shaft.turns - rate * age / 2.0;
        let tolerance = rate.abs() * age / 2.0;
        for (position, rest) in reading.positions.into_iter().zip([1.0, 0.5]) {
            let found = position.picometres() as f64 * 1e-9;
            // 24 bits are 2^-19 mm; noise of 0.2 um rms.
            let error = found - (rest + 0.25 * turns);
            assert!(error.abs() < 0.25 * tolerance + 1.2e-3, "{rate}: {found} mm, off by {error}");
        }
        let expected = (sign * turns).rem_euclid(1.0) * 4096.0;
        let off = (f64::from(reading.encoder) - expected + 2048.0).rem_euclid(4096.0) - 2048.0;
        assert!(
            off.abs() <= 4096.0 * tolerance + 1.5,
            "{rate}, {register}: {} counts, {expected}",
            reading.encoder
        );
        assert!(reading.encoder < 4096);
    }
}

/// A linear encoder measures the way of the nut: 0.1 mm are 1000 counts of 100 nm, and a reset sets the
/// present position to 0.
#[test]
fn a_linear_encoder_and_its_reset() {
    let encoder = Some(Encoder::Linear { lead: 0.25, resolution: 100 });
    let mut mastered = Mastered::new(&TxDriverConfig { encoder, ..driver(3, &[]) });
    mastered.write(&[(Entry::CanConfig, 2)]);
    let counts = |mastered: &mut Mastered| {
        mastered.start();
        mastered.master.sync().unwrap();
        mastered.run(3);
        let (reading, ..) = mastered.master.reading().unwrap();
        mastered.master.command(NmtCommand::PreOperational).unwrap();
        mastered.run(3);
        reading.encoder as i16
    };
    mastered.wired.rate = 0.4;
    mastered.run(1000);
    mastered.wired.rate = 0.0;
    assert!((counts(&mut mastered) - 1000).abs() <= 1);
    mastered.write(&[(Entry::ResetEncoder, 0)]);
    assert_eq!(counts(&mut mastered), 0);
    mastered.wired.rate = -0.4;
    mastered.run(500);
    mastered.wired.rate = 0.0;
    assert!((counts(&mut mastered) + 500).abs() <= 1);
}

/// Written values survive the reset, and the node boots with its new node-id.
#[test]
fn a_new_node_id_acts_after_the_reset() {
    let mut mastered = Mastered::new(&driver(3, &[]));
    mastered.write(&[(Entry::NodeId, 77), (Entry::CanConfig, 1), (Entry::UpdateTime, 2)]);
    mastered.master.command(NmtCommand::Reset).unwrap();
    mastered.run(20);
    assert_eq!(mastered.wired.device(0).driver().node(), node(77));
    let layout = Layout { channels: Channels::Single, encoder: false };
    mastered.master = TxMaster::new(Config::new(node(77), layout));
    mastered.run(20);
    let (reading, ..) = mastered.master.reading().expect("it starts by itself and sends");
    // 1 mm at rest, with a run-out of 20 um of order 1 and 5 um of order 2 at angle 0; noise of 0.1 um.
    let off = reading.positions[0].picometres() - mm(1).picometres();
    assert!((off - 25_000_000).abs() < 600_000, "{off} pm");
}

/// The target of a sensor may change while it measures.
#[test]
fn a_target_that_is_moved() {
    let mut mastered = Mastered::new(&driver(3, &[(Entry::CanConfig, 1), (Entry::UpdateTime, 1)]));
    for (rest, raw) in [(0.5, mm(1).raw() / 2), (-1.0, 0), (9.0, mm(2).raw())] {
        let quiet = EddyCurrentConfig { noise: 0.0, ..EddyCurrentConfig::new(2.0, Target::still(rest)) };
        let sensor = narx_sim::sensor::EddyCurrent::new(quiet).unwrap();
        mastered.wired.drivers.devices_mut()[0].set_sensors([sensor; 2]);
        mastered.run(5);
        assert_eq!(mastered.master.reading().unwrap().0.positions[0].raw(), raw, "{rest} mm");
    }
}

/// A PDO every 380 us has positions of steps of 25 us, at which the shaft has turned on between two ticks of
/// 100 us. At 10 mm/s a step is 0.25 um.
#[test]
fn drivers_sample_between_the_ticks() {
    let quiet = EddyCurrentConfig { noise: 0.0, ..EddyCurrentConfig::new(15.0, Target::nut(1.0, 1.0)) };
    let values = [(Entry::CanConfig, 1), (Entry::NrOfNodes, 1), (Entry::UpdateTime, 65_535)];
    let mut wired = Wired::new(Bitrate::K500);
    wired.add(&TxDriverConfig { sensors: [quiet; 2], ..driver(3, &values) });
    wired.run(10);
    wired.rate = 10.0;
    wired.run(10);
    let positions: Vec<f64> = wired
        .run(100)
        .iter()
        .map(|received| {
            let position = i32::from_le_bytes(received.frame.payload().try_into().unwrap());
            f64::from(position) / 134_217_728.0
        })
        .collect();
    assert!((262..=264).contains(&positions.len()), "{}", positions.len());
    let steps: Vec<f64> = positions.windows(2).map(|pair| (pair[1] - pair[0]) / 0.25e-3).collect();
    assert!(
        steps.iter().all(|steps| (steps - 15.0).abs() < 1e-3 || (steps - 16.0).abs() < 1e-3),
        "{steps:?}"
    );
    // 380 us are 15.2 steps.
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    assert!((mean - 15.2).abs() < 0.01, "{mean}");
}
