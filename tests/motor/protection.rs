//! Tests of the fault logic: every cause with its threshold, hysteresis and published qualification time,
//! mask, latch and code.

use crate::support::coefficients;
use core::ops::{Deref, DerefMut};
use narx_core::motor::clock::Instant;
use narx_core::motor::guard::fault::CauseRow;
use narx_core::motor::guard::protection::{Evidence, Protection, ProtectionCoefficients};
use narx_core::motor::machine::event::{Health, RunRequest, SlowMeasurements};
use narx_core::motor::rotor::hall::HallEvents;
use narx_core::motor::sense::measurement::Measured;
use narx_core::motor::{Cause, FaultWord, Lines};
use narx_core::units::{Amps, Celsius, Volts};

/// Evidence without a fault, in running hall closed loop with torque forward.
pub(crate) fn healthy() -> Evidence {
    Evidence {
        sensorless: None,
        measured: Measured { bus_voltage: Volts::from_milli(48_000), ..Measured::default() },
        slow: SlowMeasurements { temperature: Celsius::from_milli(25_000), pressure: Volts::ZERO },
        lines: Lines::empty(),
        health: Health::default(),
        request: RunRequest::Drive,
        hall: HallEvents::default(),
        hall_stopped: false,
        speed: 100 << 16,
        hall_driving: true,
        driving: true,
        torque: true,
        torque_sign: 1,
        open_phase: false,
    }
}

/// The fault logic, its clock, and the digital inputs that it has seen.
#[derive(Default)]
pub(crate) struct Guard {
    pub(crate) now: Instant,
    pub(crate) lines: Lines,
    protection: Protection,
}

impl Guard {
    pub(crate) fn step(&mut self, c: &ProtectionCoefficients, evidence: &Evidence) -> bool {
        self.now = self.now.next();
        self.lines = evidence.lines;
        self.protection.step(c, self.now, evidence)
    }
}

impl Deref for Guard {
    type Target = Protection;

    fn deref(&self) -> &Protection {
        &self.protection
    }
}

impl DerefMut for Guard {
    fn deref_mut(&mut self) -> &mut Protection {
        &mut self.protection
    }
}

pub(crate) fn limits(mask: u32) -> ProtectionCoefficients {
    let mut c = coefficients(&[]).protection;
    c.critical_mask = mask;
    c.shutdown_lines = Lines::DSI1;
    c
}

/// Healthy evidence with one quantity set, in thousandths of its unit.
pub(crate) fn with(cause: Cause, milli: i32) -> Evidence {
    let mut evidence = healthy();
    match cause {
        Cause::OverVoltage | Cause::UnderVoltage => evidence.measured.bus_voltage = Volts::from_milli(milli),
        Cause::OverCurrent => evidence.measured.bus_current = Amps::from_milli(milli),
        Cause::TemperatureWarning | Cause::OverTemperature => {
            evidence.slow.temperature = Celsius::from_milli(milli);
        }
        Cause::OverPressure => evidence.slow.pressure = Volts::from_milli(milli),
        Cause::Overspeed => evidence.speed = Amps::from_milli(milli).to_bits(),
        _ => panic!("{cause:?} has no quantity"),
    }
    evidence
}

fn published(cause: Cause) -> CauseRow {
    *Cause::TABLE.iter().find(|row| row.cause == cause).unwrap()
}

/// Number of ticks of 100 us of a qualification time; 0 means the tick that sees the cause.
fn ticks(cause: Cause) -> u32 {
    published(cause).qualification.div_ceil(100).max(1)
}

/// Cause, and values in thousandths: just within the threshold, just beyond, still held by hysteresis
/// (exactly at its end, where thousandths allow it), cleared.
pub(crate) const QUANTITIES: [(Cause, i32, i32, i32, i32); 8] = [
    (Cause::OverVoltage, 61_000, 61_001, 60_500, 60_499),
    (Cause::UnderVoltage, 16_000, 15_999, 16_500, 16_501),
    (Cause::OverCurrent, 7_000, 7_001, 6_563, 6_562),
    (Cause::OverCurrent, -7_000, -7_001, -6_563, -6_562),
    (Cause::TemperatureWarning, 185_000, 185_001, 183_000, 182_999),
    (Cause::OverTemperature, 190_000, 190_001, 188_000, 187_999),
    (Cause::OverPressure, 3_300, 3_301, 3_094, 3_093),
    // 4000 rpm at 4 pole pairs are 266.67 rev/s; 130 % are 346.67.
    (Cause::Overspeed, 346_666, 346_667, 266_667, 266_665),
];

#[test]
fn thresholds_hysteresis_and_qualification() {
    let c = limits(u32::MAX);
    for (cause, within, beyond, held, cleared) in QUANTITIES {
        let critical = cause != Cause::TemperatureWarning;
        let mut protection = Guard::default();
        let mut word = |evidence: &Evidence| {
            let tripped = protection.step(&c, evidence);
            assert_eq!(
                tripped,
                critical && protection.word().contains(cause.bit()) && !protection.causes_gone()
            );
            (protection.word().contains(cause.bit()), tripped)
        };
        for _ in 0..5000 {
            assert!(!word(&with(cause, within)).0, "{cause:?} at its threshold");
        }
        let needed = ticks(cause);
        // After one tick less than the qualification time and one healthy tick the count starts anew.
        for _ in 1..needed {
            assert!(!word(&with(cause, beyond)).0, "{cause:?} before {needed} ticks");
        }
        assert!(!word(&with(cause, within)).0);
        for tick in 1..=needed {
            assert_eq!(word(&with(cause, beyond)).0, tick == needed, "{cause:?} in tick {tick} of {needed}");
        }
        assert_eq!(word(&with(cause, held)), (true, critical), "{cause:?} is held by hysteresis");
        assert_eq!(
            word(&with(cause, cleared)),
            (critical, false),
            "{cause:?}: gone, and latched if critical"
        );
        assert!(protection.causes_gone());
        if critical {
            assert_eq!(protection.code(), cause as u16);
            assert_eq!(protection.critical(), cause.bit());
            protection.acknowledge();
        }
        assert_eq!((protection.word() & cause.bit(), protection.code()), (FaultWord::empty(), 0));
    }
}

/// An over-voltage of more than a volt above its threshold qualifies at once, because there is no time to
/// wait.
#[test]
fn an_over_voltage_of_more_than_a_volt_qualifies_at_once() {
    let c = limits(u32::MAX);
    for (milli, at_once) in [(61_001, false), (62_000, false), (62_001, true), (80_000, true)] {
        let mut protection = Guard::default();
        assert_eq!(protection.step(&c, &with(Cause::OverVoltage, milli)), at_once, "{milli} mV");
    }
}

/// Causes that are either present or not qualify in the tick that sees them, except the shutdown line, which
/// takes a millisecond.
#[test]
fn conditions_qualify_as_published() {
    let c = limits(u32::MAX);
    let store = |word| Health { store_faults: word, self_test_failed: false };
    let h = healthy();
    let cases = [
        (Cause::DriverLine, Evidence { lines: Lines::DRIVER_FAULT, ..h }),
        (Cause::OpenPhase, Evidence { open_phase: true, ..h }),
        (Cause::EmergencyLine, Evidence { lines: Lines::EMERGENCY, ..h }),
        (Cause::SelfTest, Evidence { health: Health { self_test_failed: true, ..Health::default() }, ..h }),
        (Cause::ShutdownCommanded, Evidence { request: RunRequest::Shutdown, ..h }),
        (Cause::ShutdownLine, Evidence { lines: Lines::DSI1, ..h }),
        (Cause::StoreMismatch, Evidence { health: store(FaultWord::STORE_MISMATCH), ..h }),
        (Cause::StoreAbsent, Evidence { health: store(FaultWord::STORE_ABSENT), ..h }),
        (Cause::StoreVersion, Evidence { health: store(FaultWord::STORE_VERSION), ..h }),
    ];
    for (cause, evidence) in cases {
        let mut protection = Guard::default();
        assert!(!protection.step(&c, &healthy()));
        let needed = ticks(cause);
        for tick in 1..=needed {
            assert_eq!(protection.step(&c, &evidence), tick == needed, "{cause:?}");
        }
        assert_eq!((protection.word(), protection.code()), (cause.bit(), cause as u16));
        assert!(!protection.step(&c, &healthy()), "{cause:?} is gone");
        assert_eq!(protection.critical(), cause.bit(), "{cause:?} is latched");
    }
    // The other digital input is not configured to shut down.
    let mut protection = Guard::default();
    assert!(!(0..100).any(|_| protection.step(&c, &Evidence { lines: Lines::DSI2, ..healthy() })));
}

/// Number of ticks until the fault, in a hall closed loop with `evidence(tick)` in every tick, and its code.
fn hall_fault(evidence: impl Fn(u32) -> Evidence) -> Option<(u32, u16)> {
    let c = limits(u32::MAX);
    let mut protection = Guard::default();
    (1..20_000).find_map(|tick| protection.step(&c, &evidence(tick)).then(|| (tick, protection.code())))
}

#[test]
fn hall_causes_count_and_forgive() {
    let hall = |hall| Evidence { hall, ..healthy() };
    let invalid = HallEvents { invalid: true, ..HallEvents::default() };
    let jump = HallEvents { jump: true, ..HallEvents::default() };
    let back = HallEvents { sectors: -1, ..HallEvents::default() };
    let quiet = HallEvents::default();
    let every =
        |period: u32, event| move |tick: u32| hall(if tick.is_multiple_of(period) { event } else { quiet });
    // 000 or 111 permanently: 64 counts, of which one is taken away per millisecond.
    assert_eq!(hall_fault(every(1, invalid)), Some((70, Cause::HallInvalid as u16)));
    assert_eq!(hall_fault(every(10, invalid)), None, "one a millisecond is forgiven");
    assert_eq!(hall_fault(every(1, jump)), Some((5, Cause::HallJumps as u16)));
    assert_eq!(hall_fault(every(131, jump)), None, "one in 13 ms is forgiven");
    assert_eq!(hall_fault(every(40, back)), Some((6 * 40, Cause::HallDirection as u16)));
    let turned = |tick| Evidence { torque: false, ..every(40, back)(tick) };
    assert_eq!(hall_fault(turned), None, "without torque whoever turns it is not to blame");
    let stalled = |_| Evidence { hall_stopped: true, ..healthy() };
    // 500 ms after the speed was found to be 0.
    assert_eq!(hall_fault(stalled), Some((5000, Cause::HallStall as u16)));
    let coasting = |_| Evidence { hall_stopped: true, torque: false, ..healthy() };
    assert_eq!(hall_fault(coasting), None, "no torque, no stall");
    let elsewhere = |_| Evidence { hall_driving: false, hall_stopped: true, ..hall(invalid) };
    assert_eq!(hall_fault(elsewhere), None, "sensors are judged in state 5");
}

/// Evidence of every maskable and forced bit.
fn present(bit: u32) -> Option<Evidence> {
    let h = healthy();
    let store = |word| Health { store_faults: word, self_test_failed: false };
    Some(match bit {
        0 => with(Cause::TemperatureWarning, 186_000),
        1 => with(Cause::OverTemperature, 191_000),
        2 => with(Cause::OverVoltage, 62_000),
        3 => with(Cause::UnderVoltage, 10_000),
        4 => with(Cause::OverCurrent, 8_000),
        5 => Evidence { lines: Lines::DRIVER_FAULT, ..h },
        6 => Evidence { hall: HallEvents { invalid: true, ..HallEvents::default() }, ..h },
        7 => with(Cause::OverPressure, 5_000),
        26 => Evidence { health: store(FaultWord::STORE_MISMATCH), ..h },
        27 => Evidence { lines: Lines::EMERGENCY, ..h },
        28 => Evidence { request: RunRequest::Shutdown, ..h },
        30 => Evidence { health: store(FaultWord::STORE_ABSENT), ..h },
        31 => Evidence { health: store(FaultWord::STORE_VERSION), ..h },
        _ => return None,
    })
}

/// Mask bit 1 = critical. Bits 2, 3, 4, 5, 27, 29 and both store bits cannot be masked while driving; bit 0
/// is never critical.
#[test]
fn mask_bit_by_bit() {
    let forced = [2, 3, 4, 5, 27, 30, 31];
    for bit in 0..32 {
        let Some(evidence) = present(bit) else { continue };
        for (mask, chosen) in [(1 << bit, true), (!(1_u32 << bit), false), (0, false), (u32::MAX, true)] {
            for driving in [false, true] {
                let c = limits(mask);
                let mut protection = Guard::default();
                // Hall sensors are judged while driving only.
                let evidence = Evidence { driving, hall_driving: driving, ..evidence };
                let critical = (0..2000).any(|_| protection.step(&c, &evidence));
                let judged = bit != 6 || driving;
                let expected = bit != 0 && judged && (chosen || (driving && forced.contains(&bit)));
                assert_eq!(critical, expected, "bit {bit}, mask {mask:08x}, driving {driving}");
                assert_eq!(protection.word().bits() >> bit & 1 == 1, judged, "live whatever the mask says");
                assert_eq!(protection.critical().bits() >> bit & 1 == 1, expected);
                assert_eq!(protection.code() >> 8 == bit as u16 && protection.code() != 0, expected);
            }
        }
    }
    // The state machine judges the time-out; here it is latched as it was raised.
    assert!(FaultWord::critical(0, true).contains(FaultWord::DEVICE_TIMEOUT));
    let mut protection = Guard::default();
    protection.raise_timeout();
    assert_eq!((protection.critical(), protection.code()), (FaultWord::DEVICE_TIMEOUT, 0x1D01));
}

#[test]
fn the_first_code_is_kept() {
    let c = limits(u32::MAX);
    let mut protection = Guard::default();
    protection.step(&c, &Evidence { lines: Lines::DRIVER_FAULT, ..healthy() });
    protection.step(&c, &Evidence { lines: Lines::EMERGENCY, ..healthy() });
    assert_eq!(protection.code(), Cause::DriverLine as u16);
    assert_eq!(protection.critical(), FaultWord::LEGS_DRIVER | FaultWord::EMERGENCY_SHUTDOWN);
}

/// Codes are bit x 256 + n, with n from 1 without gaps, and the table has each cause once.
#[test]
fn codes_are_bit_and_number() {
    let mut next = [1_u16; 32];
    for row in &Cause::TABLE {
        let code = row.cause as u16;
        let bit = code >> 8;
        assert_eq!(code & 0xFF, next[bit as usize], "{:?}", row.cause);
        next[bit as usize] += 1;
        assert_eq!(row.cause.bit().bits(), 1 << bit);
        assert!(!row.meaning.is_empty());
    }
    let used: Vec<_> = (0..32).filter(|bit| next[*bit] > 1).collect();
    assert_eq!(used, [0, 1, 2, 3, 4, 5, 6, 7, 26, 27, 28, 29, 30, 31]);
}
