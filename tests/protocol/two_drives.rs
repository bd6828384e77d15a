//! Two drives on one bus, each with its own address and master, behind one adapter.

use narx_core::bus::narmotion::Addresses;
use narx_core::dictionary::{Parameters, number};
use narx_core::master::{Config, Master};
use narx_core::motor::State;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::can::Attachment;
use narx_sim::plant::PlantConfig;
use narx_sim::presets::preset;
use std::f64::consts::TAU;

/// The benches, and what commands them.
struct Pair {
    benches: [Bench; 2],
    masters: [Master; 2],
}

impl Pair {
    /// Two of the demonstration's motors with hall sensors, their drives at 170 and 171.
    fn new() -> Self {
        let addresses =
            [0, 1].map(|more| Addresses { drive: Addresses::FACTORY.drive + more, ..Addresses::FACTORY });
        let benches = addresses.map(|addresses| {
            let mut parameters = Parameters::new();
            parameters.set(number::HALL_ENABLE, 1).unwrap();
            parameters.set(number::SLAVE_CAN_ADDRESS, addresses.drive.into()).unwrap();
            let motor = preset("bly172s-24v").unwrap().motor;
            let plant = PlantConfig::new(motor, 24.0);
            Bench::new(&BenchConfig { plant, parameters, label: String::new(), trace: false })
        });
        let masters = addresses.map(|addresses| Master::new(Config { addresses, ..Config::default() }));
        let mut pair = Self { benches, masters };
        let [first, second] = &mut pair.benches;
        assert!(second.move_beside(first));
        pair.masters.iter_mut().for_each(Master::stop);
        pair.run(0.7);
        pair
    }

    fn run(&mut self, seconds: f64) {
        let [first, second] = &mut self.benches;
        for _ in 0..(seconds * 10_000.0) as u64 {
            let now = first.now_ns() / 1000;
            for master in &mut self.masters {
                while let Some(frame) = master.poll_frame(now) {
                    // A detached host sends nothing.
                    let _ = first.send(frame);
                }
            }
            first.step();
            second.step_beside(first);
            while let Some(received) = first.receive() {
                self.masters.iter_mut().for_each(|master| master.handle_frame(&received.frame, now));
            }
        }
    }

    fn rpm(&self) -> [f64; 2] {
        self.benches.each_ref().map(|bench| bench.plant().observe().speed * 60.0 / TAU)
    }
}

#[test]
fn each_drive_obeys_its_own_master() {
    let mut pair = Pair::new();
    pair.masters[0].start(1500);
    pair.masters[1].start(-2500);
    pair.run(2.0);
    let [first, second] = pair.rpm();
    assert!(
        (first - 1500.0).abs() < 30.0 && (second + 2500.0).abs() < 50.0,
        "{first:.0} and {second:.0} rpm"
    );
    let accepted = pair.masters.each_ref().map(|master| master.report().accepted_speed.unwrap().value);
    assert_eq!(accepted, [1500, 2500]);
    // One of them stops; the other does not notice.
    pair.masters[0].stop();
    pair.run(2.0);
    let [first, second] = pair.rpm();
    assert!(first.abs() < 1.0 && (second + 2500.0).abs() < 50.0, "{first:.0} and {second:.0} rpm");
}

#[test]
fn both_stop_when_their_adapter_is_gone() {
    let mut pair = Pair::new();
    pair.masters.iter_mut().for_each(|master| master.start(2000));
    pair.run(2.0);
    pair.benches[0].set_host(Attachment::Detached);
    pair.run(0.5);
    assert_eq!(pair.benches.each_ref().map(|bench| bench.status().state), [State::Fault; 2]);
}
