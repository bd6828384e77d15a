//! Tests of the back-EMF block under faults: the signal that it follows is lost, comes out of step or too
//! early, or the motor coasts in the other direction.

use crate::blocks_beside_a_drive::{beside, sensorless_blocks};
use core::cell::Cell;
use narx_core::blocks::{ZeroCrossing, ZeroCrossingReading};
use narx_core::commissioning::Mode;
use narx_core::motor::guard::rails::Rail;
use narx_core::motor::rotor::zero_crossing::Why;
use narx_core::motor::{Direction, Samples, State, Step};
use narx_core::units::ElectricalSpeed;

/// Number of crossings that the block has followed before the fault begins.
const FOLLOWED: u32 = 200;

/// Runs a block beside a drive without sensors. Once it has followed for a while, each tick is replaced by
/// `see`, and repeated `times` times by the number of crossings so far. Returns its readings from there on,
/// up to the first that ends the episode.
fn follow(
    rpm: i32,
    see: impl Fn(&Samples) -> Samples,
    times: impl Fn(u32) -> u32,
) -> Vec<ZeroCrossingReading> {
    let mut block = None;
    let mut readings: Vec<ZeroCrossingReading> = Vec::new();
    let mut is_struck = false;
    beside(Mode::Sensorless, rpm, |session, told| {
        let block = block.get_or_insert_with(|| sensorless_blocks(session).0);
        if readings.last().is_some_and(|reading| reading.lost != Rail::None) {
            return;
        }
        if told.applied.step == Step::LockCA && told.command.step == Step::Coast {
            block.start(u32::MAX / 3 + 1, Direction::Forward);
        }
        let (seen, times) = if is_struck {
            (see(told.samples), times(readings.last().map_or(0, |reading| reading.accepted)))
        } else {
            (told.samples.clone(), 1)
        };
        for _ in 0..times {
            let reading = block.step(&seen, told.applied, Direction::Forward);
            if is_struck {
                readings.push(reading);
            }
            is_struck |= reading.running && reading.accepted > FOLLOWED;
        }
    });
    assert!(is_struck);
    readings
}

fn end(readings: &[ZeroCrossingReading]) -> Rail {
    readings.last().unwrap().lost
}

/// Once the terminals show nothing any more, six steps are commutated blind, and the loss is reported long
/// before the time-out.
#[test]
fn a_rotor_that_is_not_seen_is_lost() {
    let nothing =
        |samples: &Samples| Samples { phase_voltage: [samples.bus_voltage / 2; 3], ..samples.clone() };
    let readings = follow(1500, nothing, |_| 1);
    assert_eq!(end(&readings), Rail::Stall);
    assert!(readings.len() < 400, "{} ticks, of 500", readings.len());
    assert!(readings.iter().any(|reading| reading.why == Why::Blind));
    let before = &readings[..readings.len() - 1];
    assert!(before.iter().all(|reading| reading.lost == Rail::None && reading.running));
}

/// A rotor for which every second interval between crossings takes twice as long is reported as out of step:
/// no real rotor turns like that.
#[test]
fn a_rotor_that_is_out_of_step_is_told() {
    let readings = follow(1500, Samples::clone, |crossings| 1 + crossings % 2);
    assert_eq!(end(&readings), Rail::Desynchronised);
}

/// With time three times as fast, the next crossing comes before half of a sector has passed, and is
/// rejected.
#[test]
fn a_crossing_that_is_too_early_is_none() {
    let ticks = Cell::new(0);
    let readings = follow(600, Samples::clone, |_| {
        ticks.set(ticks.get() + 1);
        u32::from(ticks.get() % 3 == 0)
    });
    assert!(readings.iter().any(|reading| reading.why == Why::Filtered));
}

/// A block that was built for a motor turning forward and sees it coast backward follows the signals, and
/// runs.
#[test]
fn a_motor_that_coasts_the_other_way_is_followed() {
    let mut listener: Option<ZeroCrossing> = None;
    let mut last = ElectricalSpeed::default();
    let mut wakes = 0;
    beside(Mode::Sensorless, -1500, |session, told| {
        // From the time at which the drive switches the bridge off.
        let coasts = told.state == State::Standby && session.bench().status().tick > 20_000;
        if coasts {
            let block = listener.get_or_insert_with(|| sensorless_blocks(session).0);
            let reading = block.step(told.samples, told.applied, Direction::Forward);
            wakes += u32::from(reading.running);
            last = last.min(reading.speed);
        }
    });
    assert!(wakes > 1000 && last.to_bits() < -300 << 16, "{wakes} ticks, {last:?}");
}
