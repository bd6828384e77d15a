//! Tests of blocks with any input at all: they return a result, whatever a foreign driver gives them.

use narx_core::blocks::{
    Commutation, CommutationSettings, Fault, FaultSettings, Hall, HallSettings, Position, ZeroCrossing,
    ZeroCrossingSettings,
};
use narx_core::motor::commutate::pwm::Commutation as Change;
use narx_core::motor::guard::protection::Evidence;
use narx_core::motor::sense::front_end::Channel;
use narx_core::motor::{Direction, Edge, EdgeSource, PwmCommand, SampleMode, Samples, Step};
use narx_core::units::{Amps, Volts};
use proptest::prelude::*;

fn direction() -> impl Strategy<Value = Direction> {
    prop_oneof![Just(Direction::Forward), Just(Direction::Reverse)]
}

fn step() -> impl Strategy<Value = Step> {
    (0..Step::ALL.len()).prop_map(|number| Step::ALL[number])
}

fn applied() -> impl Strategy<Value = PwmCommand> {
    (step(), any::<u16>(), prop::option::of((any::<u16>(), step()))).prop_map(|(step, sample_at, change)| {
        let mut command = PwmCommand { step, sample_at, ..PwmCommand::default() };
        if let Some((instant, step)) = change {
            command.commutations.push(Change { instant, step });
        }
        command
    })
}

fn samples() -> impl Strategy<Value = Samples> {
    let edge = (any::<u16>(), any::<bool>(), any::<u8>()).prop_map(|(instant, hall, code)| {
        let source = if hall { EdgeSource::Hall } else { EdgeSource::Comparator };
        Edge { instant, source, code }
    });
    (any::<[u16; 3]>(), any::<u16>(), any::<bool>(), any::<u8>(), prop::collection::vec(edge, 0..=4))
        .prop_map(|(phase_voltage, bus_voltage, on_time, hall, edges)| Samples {
            phase_voltage,
            bus_voltage,
            sample_mode: if on_time { SampleMode::OnTime } else { SampleMode::OffTime },
            hall,
            edges: edges.into_iter().collect(),
            ..Samples::default()
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn zero_crossings_of_noise(
        ticks in prop::collection::vec((samples(), applied()), 1..80),
        micro_per_code in 1..=Channel::MICRO_PER_CODE_MAX, comparator in any::<bool>(), torque in direction(),
        back_emf_uv_per_rpm in 0..=1_000_000_u32, start in prop::option::of(any::<u32>()),
    ) {
        let channel = Channel { zero: 0, micro_per_code };
        let settings = ZeroCrossingSettings {
            terminal: channel, bus_voltage: channel, noise_codes: 255, comparator, back_emf_uv_per_rpm,
            delay_rising_us: 10_000, delay_falling_us: -10_000, timeout_ticks: 32_767, ..ZeroCrossingSettings::default()
        };
        let mut block = ZeroCrossing::build(&settings).unwrap();
        if let Some(angle) = start {
            block.start(angle, torque);
        }
        for (samples, applied) in &ticks {
            let before = block;
            let reading = block.step(samples, applied, torque);
            // Equal inputs give equal bits.
            let mut again = before;
            prop_assert_eq!(again.step(samples, applied, torque).position.angle, reading.position.angle);
            prop_assert_eq!(again, block);
        }
    }

    #[test]
    fn halls_and_commutation_of_noise(
        ticks in prop::collection::vec(samples(), 1..80), torque in direction(), captured in any::<bool>(),
        order in 0..=5_u8, polarity in 0..=7_u8, offset_cdeg in -18_000..=18_000, advance_cdeg in 0..=3000_u16, earliest in any::<u16>(),
    ) {
        let settings = HallSettings { order, polarity, offset_cdeg, captured, ..HallSettings::default() };
        let mut hall = Hall::build(&settings).unwrap();
        let mut commutation = Commutation::build(&CommutationSettings { advance_cdeg, earliest }).unwrap();
        for samples in &ticks {
            let reading = hall.step(samples.hall, &samples.edges);
            prop_assert!(reading.sector.is_none_or(|sector| sector < 6));
            let (step, changes) = commutation.step(reading.position, torque);
            prop_assert!(step.sector().is_some());
            prop_assert!(changes.iter().all(|change| change.instant >= earliest));
        }
    }

    #[test]
    fn commutation_of_any_position(places in prop::collection::vec((any::<u32>(), any::<i32>()), 1..50), torque in direction()) {
        let mut commutation = Commutation::build(&CommutationSettings::default()).unwrap();
        for (angle, speed) in places {
            // No faster than a drive may be built for: a twelfth of a turn per tick.
            let speed = speed / 12;
            let (step, _) = commutation.step(Position { angle, speed }, torque);
            prop_assert!(step.sector().is_some());
        }
    }

    #[test]
    fn faults_of_any_measurement(values in prop::collection::vec((any::<i32>(), any::<i32>(), any::<i32>()), 1..100)) {
        let mut fault = Fault::build(&FaultSettings::default()).unwrap();
        for (voltage, current, speed) in values {
            let mut evidence = Evidence { driving: true, speed, ..Evidence::default() };
            evidence.measured.bus_voltage = Volts::from_bits(voltage);
            evidence.measured.bus_current = Amps::from_bits(current);
            let critical = fault.step(&evidence);
            prop_assert!(!critical || !fault.critical().is_empty());
        }
    }
}
