//! Tests of faulty hall sensors in the whole drive: every failure has a name and a bounded time.

use crate::rotor::ScriptedRotor;
use crate::scripted::{BOOT, Scripted};
use crate::support::coefficients;
use narx_core::dictionary::number;
use narx_core::motor::{Cause, Event, RunRequest, Samples, State, Step};

fn drive(frequency: f64) -> Scripted {
    let c = coefficients(&[(number::HALL_ENABLE, 1), (number::SPEED_MIN_HES, 300)]);
    let mut script = Scripted::new(c, ScriptedRotor::new(0.2, frequency, true), 0);
    script.boot();
    // 48 V on 0.8 ohm: windings carry current, else an open phase would be detected first.
    script.blocked_current = 60.0;
    script
}

/// Number of ticks from the failure to the fault, and its code.
fn until_fault(script: &mut Scripted, limit: u64, spoil: impl Fn(&mut Samples)) -> Option<(u64, u16)> {
    for tick in 1..=limit {
        let output = script.tick(&spoil);
        if script.drive.state() == State::Fault {
            assert_eq!(output.step, Step::Coast, "off in the same tick");
            return Some((tick, script.status.extended_code));
        }
    }
    None
}

fn stick(line: u8, high: bool) -> impl Fn(&mut Samples) {
    let fix = move |code: u8| if high { code | 1 << line } else { code & !(1 << line) };
    move |samples: &mut Samples| {
        samples.hall = fix(samples.hall);
        let mut last = None;
        let edges = samples.edges.iter().copied().filter_map(|mut edge| {
            edge.code = fix(edge.code);
            (last.replace(edge.code) != Some(edge.code)).then_some(edge)
        });
        samples.edges = edges.collect();
    }
}

const HALL_CODES: [u16; 4] = [
    Cause::HallInvalid as u16,
    Cause::HallJumps as u16,
    Cause::HallStall as u16,
    Cause::HallDirection as u16,
];

/// A line that sticks high or low at speed becomes a fault, at 500 to 4000 rpm of four pole pairs, in both
/// directions.
#[test]
fn stuck_line_at_speed() {
    let mut worst = 0;
    for frequency in [33.3, 66.7, 133.3, 266.7] {
        for (line, high) in (0..3).flat_map(|line| [(line, false), (line, true)]) {
            for request in [RunRequest::Drive, RunRequest::Reverse] {
                let sign = if request == RunRequest::Drive { 1.0 } else { -1.0 };
                let mut script = drive(frequency * sign);
                script.speed = frequency as i32;
                script.ask(request);
                for _ in 0..5_000 {
                    script.tick(|_| {});
                }
                assert_eq!(script.drive.state(), State::HallClosedLoop);
                let (ticks, code) = until_fault(&mut script, 20_000, stick(line, high)).expect("a fault");
                assert!(HALL_CODES.contains(&code), "{code:04x}");
                worst = worst.max(ticks);
            }
        }
    }
    println!("a stuck line at speed becomes fault bit 6 within {worst} ticks");
    assert!(worst <= 1_500, "{worst} ticks");
}

/// A line that sticks at standstill, with a rotor that does not turn, becomes a fault: after at most the
/// time-out for which a jump is doubted (100 ms), the rise of the voltage (50 ms) and the stall time (500
/// ms); after 71 ticks where the code is invalid at once.
#[test]
fn stuck_line_from_standstill() {
    let mut worst = 0;
    for sixth in 0..6 {
        for (line, high) in (0..3).flat_map(|line| [(line, false), (line, true)]) {
            let mut script = drive(0.0);
            script.rotor.angle = (sixth as f64 + 1.0) / 6.0;
            script.ask(RunRequest::Drive);
            let (ticks, code) = until_fault(&mut script, 20_000, stick(line, high)).expect("a fault");
            assert!(HALL_CODES.contains(&code), "{code:04x}");
            worst = worst.max(ticks);
        }
    }
    println!("a stuck line at standstill becomes fault bit 6 within {worst} ticks");
    assert!(worst <= 6_500, "{worst} ticks");
}

/// Sensors without supply (111) or shorted (000) are a fault after 71 ticks.
#[test]
fn no_sensors_at_all() {
    for code in [0, 7] {
        for frequency in [0.0, 100.0] {
            let mut script = drive(frequency);
            script.ask(RunRequest::Drive);
            let spoil = |samples: &mut Samples| {
                samples.hall = code;
                samples.edges.clear();
            };
            let found = until_fault(&mut script, 20_000, spoil);
            // T15 takes one tick; the sensors are judged from the next on.
            assert_eq!(found, Some((71, Cause::HallInvalid as u16)), "{code:03b} at {frequency} rev/s");
        }
    }
}

/// A blocked rotor, with torque but without an edge, is a stall: the speed is 0 after its time-out (100 ms),
/// and the fault follows a stall time later (500 ms).
#[test]
fn blocked_rotor() {
    let mut script = drive(0.0);
    script.ask(RunRequest::Drive);
    let (ticks, code) = until_fault(&mut script, 20_000, |_| {}).expect("a fault");
    println!("a blocked rotor becomes fault {code:04x} after {ticks} ticks");
    assert_eq!(code, Cause::HallStall as u16);
    assert!((5_000..=6_010).contains(&ticks), "{ticks}");
}

/// Edges that run against the torque, as with lines swapped in pairs, are a fault.
#[test]
fn rotor_runs_against_the_torque() {
    let mut script = drive(-20.0);
    script.ask(RunRequest::Drive);
    // At less than half of the smallest set-point torque is applied against the motion.
    script.rotor.speed = -5.0 / 10_000.0;
    let (ticks, code) = until_fault(&mut script, 20_000, |_| {}).expect("a fault");
    println!("edges against the torque become fault {code:04x} after {ticks} ticks");
    assert_eq!(code, Cause::HallDirection as u16);
    // Two sectors of 333 ticks until the speed is small enough for torque, six edges, and a part of a sector.
    assert!(ticks <= 9 * 334, "{ticks}");
}

/// A tick number that wraps at the end of u64 changes nothing: the outputs are those from tick 0.
#[test]
fn a_tick_number_that_wraps() {
    let c = coefficients(&[(number::HALL_ENABLE, 1)]);
    let rotor = ScriptedRotor::new(0.2, 100.0, true);
    let mut zero = Scripted::new(c, rotor.clone(), 0);
    let mut wraps = Scripted::new(c, rotor, u64::MAX - BOOT - 300);
    for tick in 0..BOOT + 2_000 {
        if tick == BOOT + 100 {
            zero.ask(RunRequest::Drive);
            wraps.ask(RunRequest::Drive);
        }
        assert_eq!(zero.tick(|_| {}), wraps.tick(|_| {}), "tick {tick}");
    }
    assert_eq!(zero.drive.state(), State::HallClosedLoop);
    assert!(wraps.status.tick < 2_000);
}

/// A calibration applies to the next start only; after it was withdrawn the start is an ordinary one.
#[test]
fn a_calibration_is_armed_withdrawn_and_spent() {
    for (asked, expected) in [
        (&[][..], State::HallClosedLoop),
        (&[true], State::RotorLock),
        (&[true, false], State::HallClosedLoop),
        (&[true, false, true], State::RotorLock),
    ] {
        let mut script = drive(0.0);
        asked.iter().for_each(|run| script.drive.handle_event(Event::CalibrateHall(*run)));
        for state in [expected, State::HallClosedLoop] {
            script.ask(RunRequest::Drive);
            script.tick(|_| {});
            assert_eq!(script.drive.state(), state, "{asked:?}");
            script.ask(RunRequest::Standby);
            script.tick(|_| {});
            assert_eq!(script.drive.state(), State::Standby, "{asked:?}");
        }
    }
}
