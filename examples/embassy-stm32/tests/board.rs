//! The board's arithmetic, on the host: counts, scales, and the description that the core is built for.

use narx_board::stm32::{Gates, dead_time_code};
use narx_core::dictionary::{Parameters, number};
use narx_core::motor::{Coefficients, SampleMode};
use narx_core::units::Duty;
use narx_embassy_stm32::board::*;

/// Code of a voltage at a pin.
fn code(volts: f64) -> f64 {
    volts / 3.3 * 4096.0
}

#[test]
fn the_core_can_be_built_for_the_board() {
    let mut parameters = Parameters::new();
    for mode in [number::HALL_ENABLE, number::OPEN_LOOP_ENABLE] {
        parameters.set(mode, 1).unwrap();
    }
    assert!(BOARD.is_plausible());
    Coefficients::build(&parameters, &BOARD).unwrap();
}

#[test]
fn counts_are_those_of_150_mhz() {
    assert_eq!((PERIOD, TOP, DEAD_TIME), (7_500, 3_750, 120));
    assert!(dead_time_code(DEAD_TIME).is_some());
    assert_eq!(compare(Duty::from_bits(1 << 14)), TOP / 2);
    assert_eq!(compare(Duty::from_bits(1 << 15)), COMPARE_MAX);
    // The low side is on for 2 us and two dead times at the longest on-time.
    assert_eq!(2 * (TOP - COMPARE_MAX), 300 + 2 * DEAD_TIME);
    assert_eq!((part(0), part(1 << 15), part(u16::MAX)), (0, PERIOD / 2, PERIOD - 1));
    assert_eq!((sample_compare(0), sample_compare(u16::MAX)), (1, TOP - 1));
    assert!(has_come(5, 5) && has_come(u32::MAX, 3) && !has_come(6, 5));
}

#[test]
fn voltages_have_one_scale() {
    let scale = f64::from(BOARD.front_end.bus_voltage.micro_per_code) * 1e-6;
    for volts in [3.0, 12.0, 18.0] {
        let bus = code(volts * 9.31 / (169.0 + 9.31));
        assert!((bus * scale - volts).abs() < 0.01);
        let read = code(volts * 2.2 / (10.0 + 2.2)) as u16;
        let terminal = terminal(read, Gates::Off, SampleMode::OffTime, 0);
        assert!((f64::from(terminal) * scale - volts).abs() < 0.02);
    }
    // Beyond the divider's end a switched leg is at the bus.
    assert_eq!(terminal(4_095, Gates::Complementary, SampleMode::OnTime, 1_555), 1_555);
    assert!(terminal(4_095, Gates::Off, SampleMode::OnTime, 1_555) < 1_200);
}

#[test]
fn the_bus_current_is_that_of_the_low_legs() {
    // 5 A out of phase B, into its shunt: 259 mV behind the amplifier.
    let shunt = code(5.0 * 0.01 * 5.18) as i32;
    let [on, low, off] = [Gates::Complementary, Gates::Low, Gates::Off];
    let amperes = |shunts, gates, sampled| {
        (f64::from(bus_current(shunts, gates, Duty::from_bits(1 << 14), sampled)) - 2_048.0) * 0.008
    };
    // Half of the period, less 0.8 of 50 us.
    let half = 0.5 - 0.016;
    for (shunts, sampled) in [([0, shunt, 0], SampleMode::OnTime), ([-shunt, shunt, 0], SampleMode::OffTime)]
    {
        assert!((amperes(shunts, [on, low, off], sampled) - 5.0 * half).abs() < 0.03);
    }
    // All switches off: what flows, flows into the bus.
    assert!((amperes([-shunt, 0, 0], [off; 3], SampleMode::OffTime) + 5.0).abs() < 0.03);
    assert_eq!(bus_current([4_000; 3], [low; 3], Duty::from_bits(1 << 15), SampleMode::OnTime), 4_095);
}

#[test]
fn the_temperature_is_the_workbench_s() {
    let degrees = |volts| f64::from(temperature(code(volts) as u16).to_bits()) / 65_536.0;
    assert!((degrees(1.055) - 25.0).abs() < 0.1);
    assert!((degrees(2.190) - 75.0).abs() < 0.1);
}
