//! A drive that powers up with a stored set of parameters that does not build.

use narx_core::dictionary::{Parameters, number};
use narx_core::motor::State;
use narx_core::motor::guard::fault::Cause;
use narx_sim::bench::{Bench, BenchConfig};
use narx_sim::plant::{PlantConfig, SupplyConfig};
use narx_sim::presets::preset;

/// A drive whose smallest set-point is above the largest.
fn power_up() -> Bench {
    let mut parameters = Parameters::new();
    parameters.set(number::HALL_ENABLE, 1).unwrap();
    parameters.set(number::SPEED_MIN_HES, 5000).unwrap();
    let plant = PlantConfig::new(preset("bly172s-24v").unwrap().motor, 24.0);
    Bench::new(&BenchConfig { plant, parameters, label: String::new(), trace: false })
}

fn run(bench: &mut Bench, ticks: u32) {
    (0..ticks).for_each(|_| bench.step());
}

#[test]
fn it_boots_for_half_a_second_all_the_same() {
    let mut bench = power_up();
    run(&mut bench, 4_999);
    assert_eq!(bench.status().state, State::Initialization);
    run(&mut bench, 10);
    assert_eq!(bench.status().state, State::Standby);
    assert_eq!(bench.node().read_parameter(number::REJECTED_PARAMETER), Some(number::SPEED_MIN_HES.into()));
}

#[test]
fn it_is_protected_with_the_values_of_the_factory() {
    let mut bench = power_up();
    run(&mut bench, 6_000);
    bench.plant_mut().set_supply(SupplyConfig { voltage: 62.0, resistance: 0.1, may_sink: true });
    run(&mut bench, 6_000);
    assert_eq!(bench.status().state, State::Fault);
    assert_eq!(bench.status().extended_code, Cause::OverVoltage as u16);
}
