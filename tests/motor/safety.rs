//! Tests of the safety invariants of the whole tick, for any samples and any events, from any state that such
//! input can reach.

use crate::support::coefficients;
use narx_core::dictionary::number;
use narx_core::motor::machine::event::{Health, SlowMeasurements};
use narx_core::motor::{
    Coefficients, Command, Drive, Edge, EdgeSource, Event, FaultWord, Leg, Lines, PwmCommand, RunRequest,
    SampleMode, Samples, State, Status, Step,
};
use narx_core::units::{Celsius, ElectricalSpeed, Volts};
use proptest::prelude::*;

fn request() -> impl Strategy<Value = RunRequest> {
    prop_oneof![
        3 => Just(RunRequest::Drive),
        2 => Just(RunRequest::Reverse),
        2 => Just(RunRequest::Standby),
        1 => Just(RunRequest::Shutdown),
    ]
}

fn command() -> impl Strategy<Value = Event> {
    (request(), any::<i32>()).prop_map(|(request, speed)| {
        Event::Command(Command { request, speed: ElectricalSpeed::from_bits(speed) })
    })
}

/// Parameter sets that build: each mode, with various limits.
fn sets() -> impl Strategy<Value = Coefficients> {
    (0..8, 0..2, 0..10_000, 2_500..7_000, 1..3_000).prop_map(|(modes, standard, duty, current, slew)| {
        coefficients(&[
            (number::HALL_ENABLE, i32::from(modes & 1 != 0)),
            (number::OPEN_LOOP_ENABLE, i32::from(modes & 2 != 0)),
            (number::SENSORLESS_ENABLE, i32::from(modes & 4 == 0 && modes & 3 != 2)),
            (number::STANDARD_HALL_SEQUENCE, standard),
            (number::HALL_OFFSET_ANGLE, duty),
            (number::DUTY_MAX, duty.max(1_000)),
            (number::OVER_CURRENT, current),
            (number::FAULT_WAIT, 1),
            (number::LOCK_DURATION, 20),
            (number::DUTY_SLEW, slew),
        ])
    })
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        6 => command(),
        1 => sets().prop_map(Event::Coefficients),
        1 => Just(Event::CoefficientsRejected),
        1 => (prop_oneof![8 => 0..185 << 16_i32, 1 => any::<i32>()], prop_oneof![8 => Just(0), 1 => any::<i32>()]).prop_map(|(temperature, pressure)| Event::Slow(SlowMeasurements {
            temperature: Celsius::from_bits(temperature),
            pressure: Volts::from_bits(pressure),
        })),
        1 => (prop_oneof![8 => Just(0), 1 => any::<u32>()], prop::bool::weighted(0.1)).prop_map(|(bits, failed)| Event::Health(Health {
            store_faults: FaultWord::from_bits_truncate(bits & FaultWord::STORE.bits()),
            self_test_failed: failed,
        })),
        1 => any::<bool>().prop_map(Event::CalibrateHall),
    ]
}

fn edge() -> impl Strategy<Value = Edge> {
    (any::<u16>(), any::<bool>(), any::<u8>()).prop_map(|(instant, hall, code)| {
        let source = if hall { EdgeSource::Hall } else { EdgeSource::Comparator };
        Edge { instant, source, code }
    })
}

/// Any samples: often plausible ones, so that the drive goes through its states.
fn samples() -> impl Strategy<Value = Samples> {
    let voltage = prop_oneof![8 => 1_000..3_000_u16, 1 => any::<u16>()];
    let current = prop_oneof![8 => 2_000..2_300_u16, 1 => any::<u16>()];
    let lines = prop_oneof![40 => Just(0_u8), 1 => any::<u8>()];
    let edges = prop_oneof![4 => Just(Vec::new()), 1 => prop::collection::vec(edge(), 0..=4)];
    (any::<u64>(), any::<[u16; 3]>(), voltage, current, any::<u8>(), lines, edges, any::<u8>()).prop_map(
        |(tick, phase_voltage, bus_voltage, bus_current, hall, lines, edges, edges_lost)| Samples {
            tick,
            phase_voltage,
            bus_voltage,
            bus_current,
            sample_mode: if hall & 8 == 0 { SampleMode::OffTime } else { SampleMode::OnTime },
            hall,
            edges: edges.into_iter().collect(),
            edges_lost,
            lines: Lines::from_bits_retain(lines),
            ..Samples::default()
        },
    )
}

/// A stretch of equal samples after an event: states take time to be reached.
type Stretch = (Option<Event>, Samples, u16);

fn stretches() -> impl Strategy<Value = Vec<Stretch>> {
    let ticks = prop_oneof![4 => 1..20_u16, 1 => 20..1_500_u16];
    prop::collection::vec((prop::option::of(event()), samples(), ticks), 1..30)
}

/// A drive in Standby after a healthy boot; its first command is a fresh edge.
fn booted(c: &Coefficients) -> Drive {
    let mut drive = Drive::new(*c);
    let samples = Samples { bus_voltage: 2_458, bus_current: 2_048, hall: 1, ..Samples::default() };
    let idle = Command { request: RunRequest::Standby, speed: ElectricalSpeed::ZERO };
    drive.handle_event(Event::Slow(SlowMeasurements {
        temperature: Celsius::from_milli(25_000),
        pressure: Volts::ZERO,
    }));
    for _ in 0..5_001 {
        drive.handle_event(Event::Command(idle));
        drive.step(&samples);
    }
    assert_eq!(drive.state(), State::Standby);
    drive
}

/// The shortest pulse, 2 us at 10 kHz (parameter 272), raw U1F15.
const SHORTEST: u16 = 656;

/// Checks the invariants after a tick with any input.
fn check(
    drive: &Drive,
    before: &PwmCommand,
    now: &PwmCommand,
    status: Option<&Status>,
) -> Result<(), TestCaseError> {
    let patterns = || std::iter::once(now.step).chain(now.commutations.iter().map(|change| change.step));
    let off = patterns().all(|step| step.legs() == [Leg::Floating; 3]);
    let state = drive.state();
    if matches!(state, State::Initialization | State::Standby | State::Fault) {
        prop_assert!(off, "a driven leg in {state:?}");
        prop_assert_eq!(now.duty.to_bits(), 0);
    }
    if let Some(status) = status {
        // A critical fault that is present turns the bridge off in this very tick.
        prop_assert_eq!(status.state, state);
        if state.is_driving() {
            prop_assert!(status.critical.is_empty(), "driving with {:?}", status.critical);
        }
        if state == State::Fault {
            prop_assert!(off && !status.critical.is_empty() && status.extended_code != 0);
        }
    }
    prop_assert!(now.duty.to_bits() <= 32_768);
    let (last, next) = (before.duty.to_bits(), now.duty.to_bits());
    // 30 %/ms at most in the sets above, that is 3 % a tick; a current limit may reduce it eight times
    // faster; switching off is not limited, nor is a shortest pulse (2 % of the period) after one that was
    // left out.
    prop_assert!(next <= last.max(SHORTEST) + 984, "{last} -> {next}");
    prop_assert!(next == 0 || next + 8 * 984 >= last, "{last} -> {next}");
    let mut instant = 8_192;
    for change in now.commutations.iter() {
        prop_assert!(change.instant >= instant, "in order, none before `earliest`");
        instant = change.instant;
    }
    let at_boundary = now.sample_mode == SampleMode::OnTime && now.sample_at == 0;
    prop_assert!(at_boundary || now.sample_at >= next, "the sample shows what its mode says");
    Ok(())
}

fn run(drive: &mut Drive, stretches: &[Stretch]) -> Result<Vec<PwmCommand>, TestCaseError> {
    let mut outputs = Vec::new();
    let mut before = PwmCommand::default();
    let mut first = true;
    for (event, samples, ticks) in stretches {
        if let Some(event) = event {
            drive.handle_event(event.clone());
        }
        for _ in 0..*ticks {
            let now = drive.step(samples);
            let status = drive.poll_status();
            if !first {
                check(drive, &before, &now, status.as_ref())?;
            }
            first = false;
            outputs.push(now);
            before = now;
        }
    }
    Ok(outputs)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn invariants_for_any_input(c in sets(), input in stretches(), boot: bool) {
        let mut drive = if boot { booted(&c) } else { Drive::new(c) };
        run(&mut drive, &input)?;
    }

    /// A drive that was stored and restored answers as the original.
    #[test]
    fn a_snapshot_continues_alike(c in sets(), before in stretches(), after in stretches()) {
        let mut drive = booted(&c);
        run(&mut drive, &before)?;
        let mut bytes = [0; 4096];
        let bytes = postcard::to_slice(&drive, &mut bytes).unwrap();
        let mut copy: Drive = postcard::from_bytes(bytes).unwrap();
        prop_assert_eq!(&copy, &drive);
        prop_assert_eq!(run(&mut copy, &after)?, run(&mut drive, &after)?);
        prop_assert_eq!(copy, drive);
    }

    /// Any critical cause that needs no qualification turns the bridge off, in any reachable state, in the
    /// tick that sees it.
    #[test]
    fn a_critical_cause_turns_off_in_its_tick(c in sets(), before in stretches(), mut last in samples(), which in 0..4) {
        let mut drive = booted(&c);
        run(&mut drive, &before)?;
        let driving = drive.state().is_driving();
        match which {
            0 => last.lines |= Lines::EMERGENCY,
            1 => last.lines |= Lines::DRIVER_FAULT,
            2 => drive.handle_event(Event::Health(Health { self_test_failed: true, ..Health::default() })),
            _ => drive.handle_event(Event::Command(Command {
                request: RunRequest::Shutdown,
                speed: ElectricalSpeed::ZERO,
            })),
        }
        let output = drive.step(&last);
        prop_assert_eq!(output.step, Step::Coast);
        prop_assert_eq!(output.commutations.iter().count(), 0);
        prop_assert_eq!(output.duty.to_bits(), 0);
        if driving {
            prop_assert_eq!(drive.state(), State::Fault);
        }
    }
}

/// The random inputs above reach the driving states; else they would prove little.
#[test]
fn random_inputs_reach_the_driving_states() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let mut seen = [0_u32; 8];
    for _ in 0..200 {
        let c = sets().new_tree(&mut runner).unwrap().current();
        let input = stretches().new_tree(&mut runner).unwrap().current();
        let mut drive = booted(&c);
        for (event, samples, ticks) in &input {
            if let Some(event) = event {
                drive.handle_event(event.clone());
            }
            for _ in 0..*ticks {
                drive.step(samples);
                seen[drive.state() as usize] += 1;
            }
        }
    }
    println!("ticks by state: {seen:?}");
    for state in [State::Standby, State::RotorLock, State::OpenLoop, State::HallClosedLoop, State::Fault] {
        assert!(seen[state as usize] > 100, "{state:?}: {seen:?}");
    }
}
