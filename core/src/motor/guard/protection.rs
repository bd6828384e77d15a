//! Fault logic: limits with hysteresis and qualification, sensor plausibility, mask, latch and code.

mod thresholds;

pub use thresholds::Thresholds;

use super::fault::{Cause, FaultWord};
use crate::blind;
use crate::motor::band::Band;
use crate::motor::clock::Instant;
use crate::motor::machine::RunRequest;
use crate::motor::rotor::hall::HallEvents;
use crate::motor::sense::measurement::Measured;
use crate::motor::sense::samples::Lines;
use crate::units::{Celsius, Volts};
use serde::{Deserialize, Serialize};

/// Measurements that need no control tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SlowMeasurements {
    /// Ambient (power board) or external temperature, as selected and calibrated.
    pub temperature: Celsius,
    /// Pressure bridge reading after calibration.
    pub pressure: Volts,
}

/// Health of the node, for the fault logic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Health {
    /// Any of fault bits 26, 30 and 31.
    pub store_faults: FaultWord,
    /// A boot or run-time self-test failed: fault bit 27.
    pub self_test_failed: bool,
}

/// A limit with hysteresis, raw I16F16. `clear` lies on the safe side of `trip`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct Limit {
    /// Beyond this the fault qualifies.
    pub trip: i32,
    /// Back beyond this its cause is gone.
    pub clear: i32,
    /// Ticks in a row that the condition must hold, at least 1.
    pub ticks: u16,
}

/// Coefficients of the fault logic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct ProtectionCoefficients {
    /// Bus over-voltage.
    pub over_voltage: Limit,
    /// Bus voltage above which that qualifies at once.
    pub over_voltage_at_once: i32,
    /// Bus under-voltage.
    pub under_voltage: Limit,
    /// Mean DC-link current, magnitude.
    pub over_current: Limit,
    /// Temperature, shutdown.
    pub over_temperature: Limit,
    /// Temperature, warning.
    pub warning: Limit,
    /// Pressure reading, volts.
    pub over_pressure: Limit,
    /// Speed above 130 % of the mode's maximum, electrical rev/s: hall.
    pub overspeed_hall: Limit,
    /// Speed above 130 % of the maximum of sensorless and open loop.
    pub overspeed_sensorless: Limit,
    /// Which digital inputs shut down.
    pub shutdown_lines: Lines,
    /// Ticks a shutdown line must hold.
    pub shutdown_ticks: u16,
    /// Bits that are critical (parameter 115).
    pub critical_mask: u32,
    /// Ticks under torque at speed 0, which is itself parameter 113 without a hall edge (parameter 265).
    pub hall_stall_ticks: u32,
    /// Below this bus voltage a diagnostic is shown, raw I16F16.
    pub supply_low: i32,
    /// Ticks in a millisecond, 1/256: the leak of the plausibility counts.
    pub ticks_per_ms: u16,
}

impl ProtectionCoefficients {
    /// Bus currents that are no fault, raw I16F16.
    #[inline]
    pub const fn bus_current(&self) -> Band {
        Band::new(-self.over_current.trip, self.over_current.trip)
    }

    /// Digital inputs that are looked at.
    #[inline]
    pub const fn lines(&self) -> Lines {
        Lines::DRIVER_FAULT.union(Lines::EMERGENCY).union(self.shutdown_lines)
    }
}

/// One limit's memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Qualifier {
    /// Within the limit.
    #[default]
    AtRest,
    /// Beyond it since this tick, not yet for long enough.
    Qualifying(Instant),
    /// The fault is present until the value is back beyond `clear`.
    Active,
}

impl Qualifier {
    fn step(&mut self, now: Instant, beyond: bool, cleared: bool, ticks: u16) -> bool {
        *self = match *self {
            Self::Active if !cleared => Self::Active,
            Self::AtRest if beyond => Self::Qualifying(now),
            Self::Qualifying(since) if beyond => Self::Qualifying(since),
            _ => Self::AtRest,
        };
        if self.end(now, ticks).is_due(now) {
            *self = Self::Active;
        }
        *self == Self::Active
    }

    fn above(&mut self, now: Instant, limit: &Limit, value: i32) -> bool {
        self.step(now, value > limit.trip, value < limit.clear, limit.ticks)
    }

    fn below(&mut self, now: Instant, limit: &Limit, value: i32) -> bool {
        self.step(now, value < limit.trip, value > limit.clear, limit.ticks)
    }

    /// Time at which it becomes active if nothing changes.
    fn end(self, now: Instant, ticks: u16) -> Instant {
        match self {
            Self::Qualifying(since) => since.after(u32::from(ticks).saturating_sub(1)),
            Self::AtRest | Self::Active => now.after(u32::MAX),
        }
    }

    /// Lowest and highest value at which an upper limit stays as it is.
    const fn range_above(self, limit: &Limit) -> (i32, i32) {
        match self {
            Self::AtRest => (i32::MIN, limit.trip),
            Self::Qualifying(_) => (limit.trip.saturating_add(1), i32::MAX),
            Self::Active => (limit.clear, i32::MAX),
        }
    }

    /// Lowest and highest value at which a lower limit stays as it is.
    const fn range_below(self, limit: &Limit) -> (i32, i32) {
        match self {
            Self::AtRest => (limit.trip, i32::MAX),
            Self::Qualifying(_) => (i32::MIN, limit.trip.saturating_sub(1)),
            Self::Active => (i32::MIN, limit.clear),
        }
    }
}

/// `value` lies in `range`, both ends included.
const fn is_within(value: i32, range: (i32, i32)) -> bool {
    range.0 <= value && value <= range.1
}

/// Inputs of the fault logic in one tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Evidence {
    /// This tick's electrical measurements.
    pub measured: Measured,
    /// The last slow measurements.
    pub slow: SlowMeasurements,
    /// Digital inputs.
    pub lines: Lines,
    /// Store and self-tests.
    pub health: Health,
    /// The master's request.
    pub request: RunRequest,
    /// Events of the hall sensors.
    pub hall: HallEvents,
    /// No hall edge for the hall time-out.
    pub hall_stopped: bool,
    /// Speed magnitude, electrical rev/s, raw I16F16.
    pub speed: i32,
    /// The hall closed loop is running: its sensors are judged.
    pub hall_driving: bool,
    /// The bridge is on (states 2, 3, 4, 5, 7), or a start is about to turn it on.
    pub driving: bool,
    /// Torque was applied in the last tick.
    pub torque: bool,
    /// Sign of that torque: +1 forward, -1 reverse.
    pub torque_sign: i8,
    /// A phase is open.
    pub open_phase: bool,
    /// The fault of the sensorless rails, once their bucket is full.
    pub sensorless: Option<Cause>,
}

/// Plausibility counts of the hall sensors: each glitch adds, time takes away. `invalid` is time in 1/64
/// tick, `leak` in 1/256 tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct HallCounts {
    invalid: u16,
    jumps: u16,
    backwards: u16,
    stalled: u32,
    leak: u16,
}

const INVALID: u16 = 64;
const INVALID_MAX: u16 = 64;
const JUMP: u16 = 13;
const JUMPS_MAX: u16 = 64;
const BACKWARD_EDGE: u16 = 6;
const BACKWARDS_MAX: u16 = 36;

/// State of the fault logic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Protection {
    over_voltage: Qualifier,
    under_voltage: Qualifier,
    over_current: Qualifier,
    over_temperature: Qualifier,
    warning: Qualifier,
    over_pressure: Qualifier,
    overspeed: Qualifier,
    shutdown_line: Qualifier,
    /// Largest overspeed threshold of this driven episode: a limit that is lowered live is for the set-point
    /// to follow first.
    overspeed_trip: i32,
    hall: HallCounts,
    live: FaultWord,
    latched: FaultWord,
    code: u16,
    /// Extended code of the source of the rotor's position that the drive has given up, or 0; no fault.
    told: u16,
    /// A critical fault is present.
    critical: bool,
    due: Instant,
}

impl Protection {
    /// One tick. True if a critical fault is present now.
    #[inline(never)]
    pub fn step(&mut self, c: &ProtectionCoefficients, now: Instant, evidence: &Evidence) -> bool {
        let mask = FaultWord::critical(c.critical_mask, evidence.driving);
        self.live = FaultWord::empty();
        self.limits(c, now, evidence, mask);
        self.conditions(c, now, evidence, mask);
        self.hall(c, evidence, mask);
        self.critical = self.live.intersects(mask);
        self.due = self.deadline(c, now);
        self.critical
    }

    /// Something has changed that does not come with every tick's samples: the next tick looks at everything.
    pub const fn wake(&mut self, now: Instant) {
        self.due = now;
    }

    /// Time at which everything must be evaluated again. It holds while the digital inputs stay as they are,
    /// the bus voltage stays within [`calm_voltages`](Self::calm_voltages), the bus current within
    /// [`bus_current`](ProtectionCoefficients::bus_current), and the slow measurements in the range in which
    /// they [change nothing](Self::stays_calm_at).
    #[inline]
    pub const fn due(&self) -> Instant {
        self.due
    }

    /// These measurements change nothing before [`due`](Self::due).
    pub const fn stays_calm_at(&self, c: &ProtectionCoefficients, slow: &SlowMeasurements) -> bool {
        let (temperature, pressure) = (slow.temperature.to_bits(), slow.pressure.to_bits());
        is_within(temperature, self.over_temperature.range_above(&c.over_temperature))
            && is_within(temperature, self.warning.range_above(&c.warning))
            && is_within(pressure, self.over_pressure.range_above(&c.over_pressure))
    }

    /// A critical fault is present.
    pub const fn is_critical(&self) -> bool {
        self.critical
    }

    /// The speed beyond which a driven episode is too fast, raw I16F16 electrical rev/s.
    pub const fn overspeed_trip(&self) -> i32 {
        self.overspeed_trip
    }

    /// No edge backward is counted. While one is, an edge forward takes it back, so the fault logic has to
    /// see that, too.
    #[inline]
    pub const fn goes_forward(&self) -> bool {
        self.hall.backwards == 0
    }

    /// Bus voltages that change nothing before [`due`](Self::due), raw I16F16.
    pub fn calm_voltages(&self, c: &ProtectionCoefficients) -> Band {
        let (low, mut high) = self.over_voltage.range_above(&c.over_voltage);
        if matches!(self.over_voltage, Qualifier::Qualifying(_)) {
            high = c.over_voltage_at_once;
        }
        let (least, most) = self.under_voltage.range_below(&c.under_voltage);
        Band::new(low.max(least), high.min(most))
    }

    /// Current, speed and the counts of the hall sensors change from tick to tick: while one of them may
    /// become a fault, every tick looks.
    fn deadline(&self, c: &ProtectionCoefficients, now: Instant) -> Instant {
        let HallCounts { invalid, jumps, stalled, .. } = self.hall;
        let rest = [self.over_current, self.overspeed].iter().all(|limit| *limit == Qualifier::AtRest);
        if !rest || (invalid, jumps, stalled) != (0, 0, 0) {
            return now.next();
        }
        [
            (self.over_voltage, c.over_voltage.ticks),
            (self.under_voltage, c.under_voltage.ticks),
            (self.over_temperature, c.over_temperature.ticks),
            (self.warning, c.warning.ticks),
            (self.over_pressure, c.over_pressure.ticks),
            (self.shutdown_line, c.shutdown_ticks),
        ]
        .into_iter()
        .fold(now.after(u32::MAX), |due, (limit, ticks)| due.earlier(limit.end(now, ticks)))
    }

    /// A fault that the state machine decides: no command for the time-out while driving.
    pub fn raise_timeout(&mut self) {
        self.latch(Cause::CommandTimeout);
    }

    /// T06: what keeps the drive from booting is latched whatever the mask says; a Fault state has a code.
    pub fn raise_boot_failure(&mut self, health: Health) {
        let store = health.store_faults;
        for (failed, cause) in [
            (health.self_test_failed, Cause::SelfTest),
            (store.contains(FaultWord::STORE_MISMATCH), Cause::StoreMismatch),
            (store.contains(FaultWord::STORE_ABSENT), Cause::StoreAbsent),
            (store.contains(FaultWord::STORE_VERSION), Cause::StoreVersion),
        ] {
            if failed {
                self.latch(cause);
            }
        }
    }

    /// The acknowledged faults are gone; whatever is still live will be seen again in the next tick.
    pub fn acknowledge(&mut self) {
        self.latched = FaultWord::empty();
        self.code = 0;
        self.hall = HallCounts::default();
    }

    /// None of the latched causes is present any more.
    pub fn causes_gone(&self) -> bool {
        !self.live.intersects(self.latched)
    }

    /// FAULT_WORD: what is present or latched.
    pub fn word(&self) -> FaultWord {
        self.live | self.latched
    }

    /// CRITICAL_FAULT: the latched critical faults.
    pub const fn critical(&self) -> FaultWord {
        self.latched
    }

    /// Extended code of the first critical fault; without one of what was [told](Self::tell), or 0.
    pub const fn code(&self) -> u16 {
        if self.code == 0 { self.told } else { self.code }
    }

    /// A closed loop goes on by the other one's source, which is no fault, or a start begins (`None`).
    pub fn tell(&mut self, cause: Option<Cause>) {
        let told = cause.filter(|cause| !blind::to("cause", *cause as u32));
        self.told = told.map_or(0, |cause| cause as u16);
    }

    /// A driven episode has ended or begun: plausibility counts start anew.
    pub fn forget_episode(&mut self) {
        self.hall = HallCounts::default();
        self.overspeed_trip = 0;
    }

    fn present(&mut self, cause: Cause, mask: FaultWord) {
        if blind::to("cause", cause as u32) {
            return;
        }
        self.live |= cause.bit();
        if mask.contains(cause.bit()) {
            self.latch(cause);
        }
    }

    fn latch(&mut self, cause: Cause) {
        if blind::to("cause", cause as u32) {
            return;
        }
        if self.latched.is_empty() {
            self.code = cause as u16;
        }
        self.latched |= cause.bit();
    }

    fn limits(&mut self, c: &ProtectionCoefficients, now: Instant, evidence: &Evidence, mask: FaultWord) {
        let voltage = evidence.measured.bus_voltage.to_bits();
        let current = evidence.measured.bus_current.abs().to_bits();
        let temperature = evidence.slow.temperature.to_bits();
        let overspeed = if evidence.hall_driving { c.overspeed_hall } else { c.overspeed_sensorless };
        self.overspeed_trip = self.overspeed_trip.max(overspeed.trip);
        let overspeed = Limit { trip: self.overspeed_trip, ..overspeed };
        let speed = if evidence.driving { evidence.speed } else { 0 };
        let over_voltage = Limit {
            ticks: if voltage > c.over_voltage_at_once { 1 } else { c.over_voltage.ticks },
            ..c.over_voltage
        };
        let found = [
            (self.over_current.above(now, &c.over_current, current), Cause::OverCurrent),
            (self.over_voltage.above(now, &over_voltage, voltage), Cause::OverVoltage),
            (self.under_voltage.below(now, &c.under_voltage, voltage), Cause::UnderVoltage),
            (self.over_temperature.above(now, &c.over_temperature, temperature), Cause::OverTemperature),
            (self.warning.above(now, &c.warning, temperature), Cause::TemperatureWarning),
            (
                self.over_pressure.above(now, &c.over_pressure, evidence.slow.pressure.to_bits()),
                Cause::OverPressure,
            ),
            (self.overspeed.above(now, &overspeed, speed), Cause::Overspeed),
        ];
        for (active, cause) in found {
            if active {
                self.present(cause, mask);
            }
        }
    }

    fn conditions(&mut self, c: &ProtectionCoefficients, now: Instant, evidence: &Evidence, mask: FaultWord) {
        let shutdown = evidence.lines.intersects(c.shutdown_lines);
        let store = evidence.health.store_faults;
        let found = [
            (evidence.lines.contains(Lines::DRIVER_FAULT), Cause::DriverLine),
            (evidence.lines.contains(Lines::EMERGENCY), Cause::EmergencyLine),
            (evidence.health.self_test_failed, Cause::SelfTest),
            (evidence.request == RunRequest::Shutdown, Cause::ShutdownCommanded),
            (self.shutdown_line.step(now, shutdown, !shutdown, c.shutdown_ticks), Cause::ShutdownLine),
            (evidence.open_phase && evidence.driving, Cause::OpenPhase),
            (evidence.sensorless == Some(Cause::SensorlessStall), Cause::SensorlessStall),
            (evidence.sensorless == Some(Cause::Desynchronisation), Cause::Desynchronisation),
            (evidence.sensorless == Some(Cause::WrongLock), Cause::WrongLock),
            (store.contains(FaultWord::STORE_MISMATCH), Cause::StoreMismatch),
            (store.contains(FaultWord::STORE_ABSENT), Cause::StoreAbsent),
            (store.contains(FaultWord::STORE_VERSION), Cause::StoreVersion),
        ];
        for (active, cause) in found {
            if active {
                self.present(cause, mask);
            }
        }
    }

    /// Sensors are judged in the hall closed loop only, by counts that leak: one glitch is no fault.
    fn hall(&mut self, c: &ProtectionCoefficients, evidence: &Evidence, mask: FaultWord) {
        if !evidence.hall_driving {
            return;
        }
        let counts = &mut self.hall;
        // 100 us in 1/64 tick.
        let period = c.ticks_per_ms / 40;
        counts.leak = if (counts.invalid, counts.jumps) == (0, 0) { 0 } else { counts.leak + (1 << 8) };
        if counts.leak >= c.ticks_per_ms {
            counts.leak -= c.ticks_per_ms;
            counts.invalid = counts.invalid.saturating_sub(period);
            counts.jumps = counts.jumps.saturating_sub(1);
        }
        counts.invalid = counts.invalid.saturating_add(INVALID * u16::from(evidence.hall.invalid));
        counts.jumps = counts.jumps.saturating_add(JUMP * u16::from(evidence.hall.jump));
        match evidence.hall.sectors.signum() * evidence.torque_sign {
            -1 if evidence.torque => counts.backwards = counts.backwards.saturating_add(BACKWARD_EDGE),
            1 => counts.backwards = counts.backwards.saturating_sub(2),
            _ => {}
        }
        let still = evidence.hall_stopped && evidence.torque;
        counts.stalled = if still { counts.stalled.saturating_add(1) } else { 0 };
        let found = [
            (counts.invalid >= INVALID_MAX * period, Cause::HallInvalid),
            (counts.jumps >= JUMPS_MAX, Cause::HallJumps),
            (counts.backwards >= BACKWARDS_MAX, Cause::HallDirection),
            (counts.stalled >= c.hall_stall_ticks, Cause::HallStall),
        ];
        for (active, cause) in found {
            if active {
                self.present(cause, mask);
            }
        }
    }
}
