//! Tests of gains, PI, ramp and the volts-to-duty division against exact arithmetic.

use narx_core::motor::Samples;
use narx_core::motor::band::Band;
use narx_core::motor::control::pi::{Pi, PiGains};
use narx_core::motor::gain::{Gain, SIGNIFICANT_BITS};
use narx_core::motor::ramp::Ramp;
use narx_core::motor::sense::front_end::Channel;
use narx_core::motor::sense::measurement::{ChannelScale, Measurement, MeasurementScales};
use narx_core::motor::signal::ShaftScale;
use proptest::prelude::*;

fn gain(numerator: i128, denominator: i128) -> Gain {
    Gain::from_ratio(numerator, denominator).unwrap()
}

/// |`found` - floor(`numerator x value / denominator`)| within what a mantissa of at least `bits` bits allows, plus 1.
fn assert_product(found: i64, numerator: i128, denominator: i128, value: i32, bits: u32) {
    let exact = (numerator * value as i128).div_euclid(denominator);
    let allowed = (exact.abs() >> bits) + 1;
    assert!(
        (found as i128 - exact).abs() <= allowed,
        "{numerator}/{denominator} x {value} = {found}, exact {exact}, allowed {allowed}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    /// Ratios from 2^-31 up keep 30 bits; below, the number of bits decreases, down to the eight that
    /// `from_ratio` requires.
    #[test]
    fn gain_against_rationals(
        numerator in 1..1_i128 << 62,
        scale in 0..62_u32,
        denominator in 1..1_i128 << 62,
        value: i32,
    ) {
        let numerator = (numerator >> scale).max(1);
        match Gain::from_ratio(numerator, denominator) {
            Some(found) => {
                // The mantissa is the ratio in units of 2^-62, capped at 30 bits.
                let bits = (((numerator << 62) / denominator).ilog2()).min(29);
                prop_assert!(bits >= SIGNIFICANT_BITS - 1);
                let exact = numerator * value as i128 / denominator;
                if exact.abs() < i64::MAX as i128 {
                    assert_product(found.apply(value), numerator, denominator, value, bits);
                    let saturated = found.apply(value).clamp(i32::MIN as i64, i32::MAX as i64);
                    prop_assert_eq!(found.apply32(value) as i64, saturated);
                    let extended = (found.apply_extended(value) as i128) >> 16;
                    let limit = i64::MAX as i128 >> 16;
                    prop_assert_eq!(extended, (found.apply(value) as i128).clamp(-limit - 1, limit));
                }
            }
            None => {
                let large = numerator >= denominator << 30;
                let small = (numerator << 62) / denominator < 1 << (SIGNIFICANT_BITS - 1);
                let edge = numerator + 1 >= denominator << 30;
                prop_assert!(large || small || edge, "{numerator}/{denominator} refused");
            }
        }
    }
}

#[test]
fn gain_edges() {
    assert_eq!(Gain::from_ratio(0, 5), Some(Gain::ZERO));
    assert_eq!(Gain::from_ratio(-1, 5), None);
    assert_eq!(Gain::from_ratio(1, 0), None);
    assert_eq!(Gain::from_ratio(1 << 30, 1), None, "2^30 needs a mantissa of 31 bits");
    assert!(Gain::from_ratio((1 << 30) - 1, 1).is_some());
    // 8 significant bits of 2^-62: 2^-55 and no less.
    assert!(Gain::from_ratio(1, 1 << 55).is_some());
    assert_eq!(Gain::from_ratio(1, 1 << 56), None);
    // Too wide for a shift by 62: refused, not wrapped.
    assert_eq!(Gain::from_ratio(1 << 100, 1 << 100), None);
    assert_eq!(Gain::from_ratio(1, 1 << 97), None);
    for (mantissa, shift, fits) in [
        (Gain::MANTISSA_MAX, 62, true),
        (Gain::MANTISSA_MAX + 1, 0, false),
        (0, 63, false),
        (0, 0, true),
        (-1, 0, false),
    ] {
        assert_eq!(Gain::new(mantissa, shift).is_some(), fits, "{mantissa} 2^-{shift}");
    }
    assert_eq!(gain(1, 1).apply(i32::MIN), i32::MIN as i64);
    assert_eq!(gain(1, 3).apply(-1), -1, "rounds down");
    assert_eq!(gain((1 << 30) - 1, 1).apply32(i32::MAX), i32::MAX);
    for (numerator, denominator) in [(1_i128, 3_i128), (2, 3), (5, 7), (355, 113)] {
        let found = gain(numerator, denominator).apply_extended(1 << 30) as i128;
        let exact = ((numerator << 46) * 2 + denominator) / (2 * denominator);
        assert!((found - exact).abs() <= 1 << 17, "{numerator}/{denominator}: {found} {exact}");
    }
}

#[test]
fn pi_step_response_in_closed_form() {
    // Kp = 1/2, Ki per step = 1/8, error 3: u_n = 1.5 + n x 0.375, in raw units of 2^-16 exactly.
    let gains = PiGains { proportional: gain(1, 2), integral: gain(1, 8) };
    let mut pi = Pi::default();
    for n in 1..=1000_i64 {
        let expected = (3 << 16) / 2 + n * (3 << 16) / 8;
        assert_eq!(pi.step(&gains, 3 << 16, -(1 << 30), 1 << 30) as i64, expected, "step {n}");
    }
    // An error far below one output unit still integrates: 1 raw x 2^-10 a step for 2^10 x 5 steps.
    let gains = PiGains { proportional: Gain::ZERO, integral: gain(1, 1 << 10) };
    let mut pi = Pi::default();
    let last = (0..5 << 10).map(|_| pi.step(&gains, 1, -100, 100)).last();
    assert_eq!(last, Some(5));
}

proptest! {
    /// For any input the output stays within the limits. After any errors upwards, an error of `back`
    /// downwards takes the output off the upper limit at once by its whole proportional part, because the
    /// integrator was not wound up beyond that limit.
    #[test]
    fn pi_is_bounded_and_does_not_wind_up(
        errors in prop::collection::vec(-(1_i32 << 24)..1_i32 << 24, 1..50),
        back in 0..1_i32 << 24,
        kp in 0..1 << 14,
        ki in 0..1 << 12,
        a in -(1_i32 << 28)..1_i32 << 28,
        b in -(1_i32 << 28)..1_i32 << 28,
    ) {
        let (low, high) = (a.min(b), a.max(b));
        let gains = PiGains { proportional: gain(kp as i128, 1 << 10), integral: gain(ki as i128, 1 << 16) };
        let mut pi = Pi::default();
        for error in errors {
            let output = pi.step(&gains, error, low, high);
            prop_assert!((low..=high).contains(&output));
        }
        pi.step(&gains, 1, low, high);
        let change = gains.integral.apply(-back) + gains.proportional.apply(-back);
        let most = (high as i64 + change).clamp(low as i64, high as i64);
        prop_assert!(pi.step(&gains, -back, low, high) as i64 <= most + 2);
    }

    /// A controller that something else has overridden takes over from the applied output, whatever it did
    /// before: its next output differs by only one step of its integral.
    #[test]
    fn tracking_hands_over_without_a_bump(
        before in prop::collection::vec(-1_000_000..1_000_000_i32, 0..20),
        applied in 0..3_000_000_i32,
        error in -1_000_000..1_000_000_i32,
        kp in 1..1 << 16,
        ki in 1..1 << 12,
    ) {
        let gains = PiGains { proportional: gain(kp as i128, 1 << 12), integral: gain(ki as i128, 1 << 16) };
        let mut pi = Pi::default();
        for error in before {
            pi.step(&gains, error, 0, 1 << 22);
        }
        // An eighth per tick: after 200 ticks the earlier state has decayed.
        (0..200).for_each(|_| pi.track(&gains, applied, error, 1 << 13));
        let expected = (applied as i64 + gains.integral.apply(error)).clamp(0, 1 << 22);
        prop_assert!((pi.step(&gains, error, 0, 1 << 22) as i64 - expected).abs() <= 2);
        pi.wait(applied);
        prop_assert_eq!(pi.step(&gains, 0, 0, 1 << 22), applied);
    }

    /// A ramp has the exact rate, never passes the target, and takes the exact number of steps.
    #[test]
    fn ramp_rate_and_arrival(start: i32, target: i32, rate in 1..i64::MAX >> 16) {
        let mut ramp = Ramp::default();
        ramp.set(start);
        let (from, to) = ((start as i64) << 16, (target as i64) << 16);
        let sign = (to - from).signum();
        for n in 1..=40_i64 {
            let travelled = (rate as i128 * n as i128).min((to - from).abs() as i128) as i64;
            prop_assert_eq!(ramp.step(target, rate) as i64, (from + sign * travelled) >> 16);
        }
        let needed = (to - from).unsigned_abs().div_ceil(rate as u64);
        if needed <= 40 {
            prop_assert_eq!(ramp.value(), target);
        }
    }
}

#[test]
fn slow_ramps_move_and_no_rate_stands_still() {
    // 2^-32 of a unit a step: one raw bit after 65 536 steps, to the step.
    let mut ramp = Ramp::default();
    assert_eq!((0..65_535).map(|_| ramp.step(5, 1)).last(), Some(0));
    assert_eq!(ramp.step(5, 1), 1);
    assert_eq!(ramp.step(5, 0), 1);
    assert_eq!(ramp.step(5, -7), 1, "a negative rate is none");
    let mut ramp = Ramp::default();
    ramp.set(i32::MIN);
    assert_eq!(ramp.step(i32::MAX, i64::MAX), i32::MAX);
}

/// A front end of 1.2 mV resolution: 65 536 codes up to 80 V.
fn fine_scales() -> MeasurementScales {
    let scale = ChannelScale::new(Channel { zero: 0, micro_per_code: 1_221 }, 0);
    MeasurementScales { bus_voltage: scale, bus_current: scale, phase_voltage: scale, filter: 1 << 16 }
}

fn assert_duty(measurement: &Measurement, bus: i32, voltage: i32) -> Result<(), TestCaseError> {
    let exact = (voltage as f64 / bus as f64 * 32_768.0).min(32_768.0);
    let found = measurement.duty(voltage).to_bits() as f64;
    let allowed = 1.0 + exact * 1e-4;
    prop_assert!((found - exact).abs() <= allowed, "{voltage} of {bus}: {found}, exact {exact}");
    // Without either limit it is the same; this form requires a bus above 4 V.
    if measurement.bus_voltage() > 4 << 16 && (1..measurement.bus_voltage()).contains(&voltage) {
        prop_assert_eq!(measurement.duty_within(voltage), found as u32, "{} of {}", voltage, bus);
    }
    Ok(())
}

/// A band gives the same as two comparisons.
#[test]
fn a_band_holds_what_lies_between_its_ends() {
    let values = [i32::MIN, -65_537, -1, 0, 1, 65_536, i32::MAX];
    for low in values {
        for high in values.into_iter().filter(|high| i64::from(*high) - i64::from(low) < i64::from(u32::MAX))
        {
            let band = Band::new(low, high);
            assert_eq!(band.is_empty(), low > high, "{low}..={high}");
            for value in values {
                assert_eq!(band.contains(value), (low..=high).contains(&value), "{value} in {low}..={high}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    /// With a bus of 4 to 80 V, in steps of up to 8 % a tick and in jumps, the duty is right in the same
    /// tick.
    #[test]
    fn duty_follows_the_bus(
        first in 4.0..80.0_f64,
        walk in prop::collection::vec((-0.08..0.08_f64, prop::option::weighted(0.02, 4.0..80.0_f64)), 1..300),
        voltages in prop::collection::vec(0..80 << 16_i32, 4),
    ) {
        let scales = fine_scales();
        let mut measurement = Measurement::default();
        let mut volts = first;
        for (step, jump) in walk {
            volts = jump.unwrap_or((volts * (1.0 + step)).clamp(4.0, 79.0));
            let samples = Samples { bus_voltage: (volts * 65_536.0 / 80.0) as u16, ..Samples::default() };
            measurement.step(&scales, &samples);
            for voltage in &voltages {
                assert_duty(&measurement, measurement.bus_voltage().max(4 << 16), *voltage)?;
            }
        }
    }
}

#[test]
fn duty_without_a_bus_is_finite() {
    let mut measurement = Measurement::default();
    for code in [0, u16::MAX, 0, 1, u16::MAX] {
        measurement.step(&fine_scales(), &Samples { bus_voltage: code, ..Samples::default() });
        assert_eq!(measurement.duty(0).to_bits(), 0);
        assert_eq!(measurement.duty(-1).to_bits(), 0);
        assert_eq!(measurement.duty(i32::MAX).to_bits(), 32_768);
    }
}

/// A channel beyond the range for boards, or an offset beyond the range of a calibration, counts as the
/// nearest allowed one: no product overflows.
#[test]
fn a_channel_and_its_offset_are_bounded() {
    let channel = |micro_per_code| Channel { zero: 100, micro_per_code };
    let most = Channel::MICRO_PER_CODE_MAX;
    for (channel, offset, like) in [
        (channel(most + 1), 0, (channel(most), 0)),
        (channel(i32::MAX), 0, (channel(most), 0)),
        (channel(-1), 7, (channel(0), 7)),
        (channel(1000), i32::MAX, (channel(1000), 1 << 24)),
        (channel(1000), i32::MIN, (channel(1000), -(1 << 24))),
    ] {
        let (found, expected) = (ChannelScale::new(channel, offset), ChannelScale::new(like.0, like.1));
        assert_eq!(found, expected, "{channel:?} {offset}");
        assert_eq!(found.convert(100), like.1, "its zero, less the offset");
    }
}

/// A motor of no pole pairs, which no parameter can request, is scaled as one of one.
#[test]
fn a_speed_has_at_least_one_pole_pair() {
    let [none, one, four] = [0, 1, 4].map(|pairs| ShaftScale::new(pairs).speed(100 << 16));
    assert_eq!((none, one / 4), (one, four));
}

/// With gains that no motor needs neither part overflows, and the output ends at its limit.
#[test]
fn a_controller_with_any_gains_stays_within_its_limits() {
    let most = Gain::new(Gain::MANTISSA_MAX, 0).unwrap();
    for (proportional, integral) in [(Gain::ZERO, most), (most, Gain::ZERO), (most, most)] {
        for (error, expected) in [(i32::MAX, 7), (i32::MIN, -3)] {
            let mut pi = Pi::default();
            let gains = PiGains { proportional, integral };
            for _ in 0..3 {
                assert_eq!(pi.step(&gains, error, -3, 7), expected, "{gains:?} {error}");
            }
        }
    }
}
