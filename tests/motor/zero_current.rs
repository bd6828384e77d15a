//! Tests of the bus current's zero: it is found while the bridge is off, again and again, and never from a
//! real current.

use crate::bench::Closed;
use crate::robustness::config;
use narx_core::dictionary::number;
use narx_core::motor::{RunRequest, State};
use narx_sim::plant::{Injection, LoadConfig};

/// Ticks after which, in Standby, the mean of 64 ms has settled to a thousandth.
const SETTLED: u64 = 8 * 1024;

/// Mean bus current over 20 ms, A, once the drive's filter has settled: the published and the true value.
fn mean_current(closed: &mut Closed) -> (f64, f64) {
    closed.run(640);
    let mut sum = (0.0, 0.0);
    for _ in 0..400 {
        closed.tick();
        sum.0 += f64::from(closed.status.bus_current.to_bits()) / 65_536.0;
        sum.1 += closed.plant.observe().bus_current;
    }
    (sum.0 / 400.0, sum.1 / 400.0)
}

fn assert_shows(closed: &mut Closed, amps: f64, when: &str) {
    let (shown, _) = mean_current(closed);
    assert!((shown - amps).abs() < 0.015, "{when}: {shown} A, not {amps}");
}

/// If a load behind the shunt takes 0.22 A while the drive boots, and is removed then, the zero is found anew
/// in Standby. If it were kept, the zero of that moment would hold the current limit of a small motor at no
/// duty at all, permanently and without a fault.
#[test]
fn a_zero_that_was_wrong_at_power_up_is_found_anew_in_standby() {
    let mut closed = Closed::new(&config(24.0), &[]);
    let leak = Injection::Leak(24.0 / 0.22);
    closed.plant.inject(leak);
    closed.boot();
    assert_shows(&mut closed, 0.0, "with the leak from the beginning");
    closed.plant.clear(leak);
    closed.run(SETTLED);
    assert_shows(&mut closed, 0.0, "mended");
    // While it drives, the zero is kept: a reading is a current.
    closed.ask(RunRequest::Drive);
    closed.run(16_000);
    let (before, _) = mean_current(&mut closed);
    closed.plant.inject(leak);
    closed.run(SETTLED);
    assert_shows(&mut closed, before + 0.22, "a leak while it drives");
}

/// Parameter 13 is added to the measurement, and stays so: it does not count as an offset of the channel.
#[test]
fn what_parameter_13_adds_is_never_taken_for_the_zero() {
    for milliamperes in [-700, -120, 120, 700] {
        let amps = f64::from(milliamperes) * 1e-3;
        let changes = [(number::HV_CURRENT_OFFSET, milliamperes)];
        let mut stored = Closed::new(&config(24.0), &changes);
        stored.boot();
        assert_shows(&mut stored, amps, "from power-up");
        let mut written = Closed::new(&config(24.0), &[]);
        written.boot();
        written.configure(&changes);
        assert_shows(&mut written, amps, "as soon as it is written");
        written.run(SETTLED);
        assert_shows(&mut written, amps, "later");
        written.configure(&[]);
        assert_shows(&mut written, 0.0, "taken back");
    }
}

/// A coasting motor feeds a battery whose voltage sags through the diodes. This current is no zero: a drive
/// that starts again at once reads the true current.
#[test]
fn what_a_coasting_motor_feeds_back_is_no_zero() {
    let mut config = config(24.0);
    config.supply.may_sink = true;
    let mut closed = Closed::new(&config, &[(number::UNDER_VOLTAGE, 8_000)]);
    closed.set_point = 4000.0;
    closed.boot();
    closed.plant.set_load(LoadConfig { inertia: 1e-4, ..LoadConfig::default() });
    closed.ask(RunRequest::Drive);
    closed.run(30_000);
    let sag = Injection::Supply(12.0);
    closed.ask(RunRequest::Standby);
    closed.plant.inject(sag);
    let mut fed = 0.0;
    for _ in 0..600 {
        closed.tick();
        fed -= closed.plant.observe().bus_current / 600.0;
    }
    assert!(fed > 1.0 && closed.drive.state() == State::Standby, "{fed} A into {:?}", closed.drive.state());
    closed.plant.clear(sag);
    closed.ask(RunRequest::Drive);
    closed.run(20_000);
    let (shown, flows) = mean_current(&mut closed);
    assert_eq!(closed.drive.state(), State::HallClosedLoop);
    assert!((shown - flows).abs() < 0.015, "{shown} A of {flows}");
}
