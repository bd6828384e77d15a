//! Tests of the current ratings and the names of their limits.

use narx_core::motor::control::limits::{CurrentLimit, LimitCoefficients};
use narx_core::motor::gain::Gain;
use narx_core::motor::machine::event::Limiter;
use narx_core::units::{Celsius, Volts};

const AMPERE: i32 = 1 << 16;

fn coefficients() -> LimitCoefficients {
    LimitCoefficients {
        soft_start: 3 * AMPERE,
        maximum: 6 * AMPERE,
        rate: ((60 * AMPERE as i64) << 16) / 1000,
        phase_current_max: 12 * AMPERE,
        derating_start: 185 << 16,
        derating: Gain::from_ratio(65_536, 5 << 16).unwrap(),
        bridge: 0,
    }
}

/// Bus voltage and current in the form in which the limit takes them.
fn bus(volts_milli: i32, current: i32) -> (i32, i32) {
    (Volts::from_milli(volts_milli).to_bits(), current)
}

/// Current limit of a motor that has taken all of it for half a second.
fn settled(volts: i32, celsius_milli: i32) -> CurrentLimit {
    let c = coefficients();
    let mut limit = CurrentLimit::default();
    limit.start(&c);
    for _ in 0..500 {
        let drawn = limit.bound(u16::MAX >> 1).0;
        limit.update(&c, bus(volts, drawn), 0, Celsius::from_milli(celsius_milli), true);
    }
    limit
}

fn bound(limit: &CurrentLimit, duty: f64) -> (f64, Limiter) {
    let (bound, name) = limit.bound((duty * 32_768.0) as u16);
    (bound as f64 / AMPERE as f64, name)
}

fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 2e-3, "{found} A, expected {expected} A");
}

/// The power rating of Table 1 is 150 W up to and including 48 V and 300 W above, and never more than
/// parameter 106.
#[test]
fn power_rating_by_bus_voltage() {
    for (volts, amperes, name) in [
        (18_000, 6.0, Limiter::Current),
        (24_900, 6.0, Limiter::Current),
        (30_000, 5.0, Limiter::Power),
        (48_000, 150.0 / 48.0, Limiter::Power),
        (48_020, 150.0 / 48.02, Limiter::Power),
        (48_600, 6.0, Limiter::Current),
        (56_000, 300.0 / 56.0, Limiter::Power),
        (60_000, 5.0, Limiter::Power),
    ] {
        let (found, by) = bound(&settled(volts, 25_000), 1.0);
        assert_near(found, amperes);
        assert_eq!(by, name, "{volts} mV");
    }
}

/// The power rating of Table 1 is output power: the loss of 8 A in 0.5 ohm of switches, 32 W, may enter the
/// bridge in addition.
#[test]
fn power_rating_is_what_leaves_the_bridge() {
    let c = LimitCoefficients { bridge: AMPERE / 2, ..coefficients() };
    let mut limit = CurrentLimit::default();
    limit.start(&c);
    for _ in 0..500 {
        let drawn = limit.bound(u16::MAX >> 1).0;
        limit.update(&c, bus(48_000, drawn), 8 * AMPERE, Celsius::from_milli(25_000), true);
    }
    let (found, by) = bound(&limit, 1.0);
    assert_near(found, (150.0 + 32.0) / 48.0);
    assert_eq!(by, Limiter::Power);
}

/// The power rating is thermal: a pulse of a few milliseconds passes, and a lasting excess is reduced within
/// 0.1 s.
#[test]
fn power_rating_forgives_a_pulse() {
    let c = coefficients();
    let mut limit = settled(24_000, 25_000);
    let mut after = |milliseconds: u32| {
        for _ in 0..milliseconds {
            limit.update(&c, bus(30_000, 6 * AMPERE), 0, Celsius::from_milli(25_000), true);
        }
        bound(&limit, 1.0)
    };
    let (found, _) = after(2);
    assert!(found > 5.8, "{found} A");
    let (found, by) = after(98);
    assert!(found < 5.0, "{found} A");
    assert_eq!(by, Limiter::Power);
}

/// The bus shunt measures phase current x duty: 12 A in the phase is 12 A x D on the bus.
#[test]
fn phase_current_bound() {
    let limit = settled(24_000, 25_000);
    for duty in [0.0, 0.1, 0.25, 0.49] {
        let (found, by) = bound(&limit, duty);
        assert_near(found, 12.0 * duty);
        assert_eq!(by, Limiter::PhaseCurrent);
    }
    assert_eq!(bound(&limit, 0.6).1, Limiter::Current);
}

/// Derating is linear from the warning at 185 C to nothing at 190 C, on the bus and on the phase bound alike.
#[test]
fn temperature_derating() {
    for (celsius, share) in
        [(185_000, 1.0), (186_000, 0.8), (187_500, 0.5), (189_000, 0.2), (190_000, 0.0), (250_000, 0.0)]
    {
        let limit = settled(24_000, celsius);
        let (found, by) = bound(&limit, 1.0);
        assert_near(found, 6.0 * share);
        assert_eq!(by, if celsius > 185_000 { Limiter::Temperature } else { Limiter::Current });
        let (found, _) = bound(&limit, 0.25);
        assert_near(found, (12.0 * 0.25 * share).min(6.0 * share));
    }
}

/// The soft start is parameter 105 until the rotor turns, then it rises at parameter 96: 60 A/s is 3 A in 50
/// ms.
#[test]
fn soft_start_and_its_rate() {
    let c = coefficients();
    let mut limit = CurrentLimit::default();
    limit.start(&c);
    let update = |limit: &mut CurrentLimit, turns| {
        limit.update(&c, bus(24_000, 0), 0, Celsius::from_milli(25_000), turns);
        bound(limit, 1.0).0
    };
    for _ in 0..100 {
        assert_near(update(&mut limit, false), 3.0);
    }
    for milliseconds in 1..=60 {
        assert_near(update(&mut limit, true), (3.0 + 0.06 * milliseconds as f64).min(6.0));
    }
}

/// The phase current is rated by heat. Table 2 gives 12 A peak, 6 A rms continuous, which in six-step is 7.35
/// A. The peak current is available for 2 s from cold, then the bound falls to the continuous one. A new
/// start does not cool the drive, time does.
#[test]
fn phase_current_is_rated_by_heat() {
    let c = coefficients();
    let mut limit = CurrentLimit::default();
    limit.start(&c);
    let run = |limit: &mut CurrentLimit, seconds: u32, amperes: Option<f64>| {
        for _ in 0..seconds * 1000 {
            let phase = amperes.unwrap_or(f64::from(limit.bound(1 << 13).0) * 4.0 / f64::from(AMPERE));
            limit.update(
                &c,
                bus(60_000, 0),
                (phase * f64::from(AMPERE)) as i32,
                Celsius::from_milli(25_000),
                true,
            );
        }
        bound(limit, 0.25).0 * 4.0
    };
    assert_near(run(&mut limit, 60, Some(7.3)), 12.0);
    let warm = run(&mut limit, 1, None);
    assert!((8.5..11.5).contains(&warm), "{warm} A after a second of all there is");
    let hot = run(&mut limit, 60, None);
    assert!((hot - 7.35).abs() < 0.05, "{hot} A for good");
    limit.start(&c);
    let restarted = run(&mut limit, 1, None);
    assert!((restarted - 7.35).abs() < 0.05, "{restarted} A after a restart");
    assert_near(run(&mut limit, 4, Some(0.0)), 12.0);
}
