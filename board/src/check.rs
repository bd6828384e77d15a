//! Check of a board: compares what it measures with what its description says, before a drive relies on
//! either.
//!
//! [`BoardCheck`] takes the place of the drive in the control interrupt: samples in, PWM command out. It
//! first measures with the bridge off, then locks one leg after the other at a small duty, and with a motor
//! lets the field stand at six places. After the first finding that is wrong it drives nothing any more.
//!
//! ```text
//!   bridge off     current zero, bus voltage
//!   A, B, C alone  phase order, terminal voltage            each leg switched, both others low
//!   A alone        dead time                                the duty rises until the terminal follows
//!   six locks      current sign, hall lines, hall wiring    with a motor whose shaft is free
//! ```
//!
//! On the host `tests/check.rs` of this package runs the check with a simulated motor as its board. The PWM
//! rate needs a second clock: [`pwm_rate`] checks it.

use core::fmt;
use narx_core::motor::commutate::commutation::LOCKS;
use narx_core::motor::rotor::hall::{HallWiring, sectors};
use narx_core::motor::{
    Board, Channel, Commutations, FrontEnd, PwmCommand, Rectification, SampleMode, Samples, Step,
};
use narx_core::units::{Amps, Duty, Volts};

/// Property of the board that is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// Control ticks a second against another clock, Hz.
    PwmRate,
    /// Code of the bus current with the bridge off.
    CurrentZero,
    /// Bus voltage against a meter, mV.
    BusVoltage,
    /// Terminal that follows when one leg is switched: 0 is A.
    PhaseOrder,
    /// Voltage of the switched terminal against the bus, mV.
    TerminalVoltage,
    /// Half of the shortest on-time in whose middle the terminal is high, ns.
    DeadTime,
    /// Bus current while a lock drives, mA.
    CurrentLimit,
    /// Bus current of the six locks, mean, mA: positive from the supply into the bridge.
    CurrentSign,
    /// Different hall codes at six places of the rotor.
    HallLines,
    /// Order of the hall lines (parameter 262), -1 if no order explains the codes.
    HallOrder,
    /// Inverted hall lines (parameter 263), bit 0 is A.
    HallPolarity,
}

impl Check {
    /// Returns the name, and the unit of its figures.
    pub const fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::PwmRate => ("PWM rate", "Hz"),
            Self::CurrentZero => ("current zero", "codes"),
            Self::BusVoltage => ("bus voltage", "mV"),
            Self::PhaseOrder => ("phase order", ""),
            Self::TerminalVoltage => ("terminal voltage", "mV"),
            Self::DeadTime => ("dead time", "ns"),
            Self::CurrentLimit => ("current limit", "mA"),
            Self::CurrentSign => ("current sign", "mA"),
            Self::HallLines => ("hall lines", ""),
            Self::HallOrder => ("hall order", ""),
            Self::HallPolarity => ("hall polarity", ""),
        }
    }

    /// Returns what to look at when the check fails.
    pub const fn advice(self) -> &'static str {
        match self {
            Self::PwmRate => {
                "compare the timer's clock and reload with Board::tick_rate; a centre-aligned timer \
                counts up and down in one period, and its repetition counter decides whether one or both \
                ends interrupt"
            }
            Self::CurrentZero => {
                "set front_end.bus_current.zero to the measured code if the amplifier's bias explains it; \
                a code at 0 or 4095 is an amplifier without supply or a wrong converter channel"
            }
            Self::BusVoltage => {
                "compute front_end.bus_voltage.micro_per_code anew from the divider and the converter's \
                reference; a reading that is much too small is a sampling time too short for the divider"
            }
            Self::PhaseOrder => {
                "one of the legs, their timer channels or the converter's terminal channels is exchanged; \
                -1 is a terminal that does not follow at all: the driver is not enabled, a gate is missing, \
                or the sample is not taken in the middle of the on-time"
            }
            Self::TerminalVoltage => {
                "compute front_end.phase_voltage.micro_per_code anew from the terminals' dividers; they \
                need the same scale for all three phases"
            }
            Self::DeadTime => {
                "compare the timer's dead-time register with Board::dead_time_ns; a driver that inserts a \
                dead time of its own adds to it"
            }
            Self::CurrentLimit => {
                "the motor draws more than was given: lower the duty, or look for a short circuit"
            }
            Self::CurrentSign => {
                "current into the bridge is positive: exchange the amplifier's inputs in the arithmetic, \
                or the shunt's"
            }
            Self::HallLines => {
                "turn the shaft by hand and look at each line: one is not connected, has no pull-up or no \
                supply, or the rotor was held"
            }
            Self::HallOrder => {
                "set parameter 262 to the measured order, or exchange hall lines; 1, 2 and 5 are also two \
                exchanged phases of the motor; -1 is a rotor that did not follow"
            }
            Self::HallPolarity => "set parameter 263 to the measured mask",
        }
    }
}

/// Measurements of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Property that was compared.
    pub check: Check,
    /// Phase that it was measured on; `None` if it is not of one phase.
    pub phase: Option<u8>,
    /// Measured value, in the check's unit.
    pub measured: i32,
    /// Expected value.
    pub expected: i32,
    /// Largest deviation that passes.
    pub tolerance: u32,
}

impl Finding {
    /// Returns whether the measured value is the expected one, within the tolerance.
    pub const fn passes(&self) -> bool {
        self.measured.abs_diff(self.expected) <= self.tolerance
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, unit) = self.check.name();
        let phase = match self.phase {
            Some(0) => " of A",
            Some(1) => " of B",
            Some(_) => " of C",
            None => "",
        };
        let Self { measured, expected, tolerance, .. } = self;
        let (verdict, gap) =
            (if self.passes() { "ok  " } else { "FAIL" }, if unit.is_empty() { "" } else { " " });
        write!(f, "{verdict} {name}{phase}: {measured}{gap}{unit}, expected {expected}")?;
        if *tolerance > 0 {
            write!(f, " +- {tolerance}")?;
        }
        if !self.passes() {
            write!(f, ": {}", self.check.advice())?;
        }
        Ok(())
    }
}

/// Compares the PWM rate: `ticks` control interrupts in `elapsed_us` of another clock, which may be 2 % off.
/// An elapsed time of 0 measures 0 Hz.
pub const fn pwm_rate(board: &Board, ticks: u32, elapsed_us: u32) -> Finding {
    let measured = (ticks as u64 * 1_000_000).checked_div(elapsed_us as u64);
    let measured = match measured {
        Some(rate) if rate <= i32::MAX as u64 => rate as i32,
        Some(_) => i32::MAX,
        None => 0,
    };
    let expected = board.tick_rate as i32;
    Finding { check: Check::PwmRate, phase: None, measured, expected, tolerance: board.tick_rate / 50 }
}

/// Facts that the check cannot measure by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Given {
    /// Bus voltage by a meter.
    pub supply: Volts,
    /// Duty of the locks: some percent, beyond the dead time.
    pub duty: Duty,
    /// Bus current beyond which the bridge is turned off at once.
    pub current_max: Amps,
    /// A motor with hall sensors is connected and its shaft is free.
    pub motor: bool,
}

/// Reason for which a check cannot begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GivenError {
    /// The description is not plausible ([`Board::is_plausible`]).
    Board,
    /// The duty, 1/32 768, is not between three times the dead time and a quarter: given, smallest and
    /// largest.
    Duty(u16, u16, u16),
}

impl fmt::Display for GivenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Board => f.write_str("the board's description is not plausible (Board::is_plausible)"),
            Self::Duty(given, least, most) => {
                write!(f, "duty {given}/32768: expected {least} to {most}, three dead times to a quarter")
            }
        }
    }
}

impl core::error::Error for GivenError {}

/// Most findings of one check.
const FINDINGS: usize = 13;
/// Locks in each of which the rotor has time to come to rest: one electrical turn to align it, and the one
/// that counts.
const PLACES: u8 = 12;
/// Ticks over which a lock's voltages are averaged, after as many that are left out.
const LOCK_TICKS: u32 = 16;
/// A scale that is this much off fails, 1/100: dividers of 1 % resistors reach 2.
const SCALE_PERCENT: i32 = 3;
/// Largest deviation of the current's zero, codes: 2 % of the converter's range.
const ZERO_CODES: u32 = 82;
/// Largest deviation of the dead time, ns: rise of a terminal, and aperture of a converter.
const DEAD_TIME_NS: u32 = 200;
/// Smallest negative mean of the bus current that is not noise, mA.
const SIGN_MA: u32 = 100;
/// Largest duty of the search for the dead time, and of a lock: a quarter.
const QUARTER: u16 = 1 << 13;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Off,
    Leg(u8),
    DeadTime,
    Place(u8),
    Done,
}

/// Sums of a stage.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    bus: u32,
    current: u32,
    terminals: [u32; 3],
    ticks: u32,
}

impl Sums {
    fn add(&mut self, samples: &Samples) {
        self.bus += u32::from(samples.bus_voltage);
        self.current += u32::from(samples.bus_current);
        for (sum, code) in self.terminals.iter_mut().zip(samples.phase_voltage) {
            *sum += u32::from(code);
        }
        self.ticks += 1;
    }

    /// Mean of one of the sums in milli-units.
    fn milli(&self, sum: u32, channel: Channel) -> i32 {
        let ticks = i64::from(self.ticks.max(1));
        let codes = i64::from(sum) - i64::from(channel.zero) * ticks;
        (codes * i64::from(channel.micro_per_code) / (1000 * ticks)) as i32
    }
}

/// The check, in place of the drive.
#[derive(Clone, Debug)]
pub struct BoardCheck {
    board: Board,
    given: Given,
    stage: Stage,
    /// Ticks of the stage so far.
    ticks: u32,
    sums: Sums,
    /// Duty of the search for the dead time, 1/32 768.
    search: u16,
    halls: [u8; 6],
    /// Sum of the bus currents of the places, mA.
    driven: i32,
    findings: [Option<Finding>; FINDINGS],
}

impl BoardCheck {
    /// A check that has measured nothing yet.
    ///
    /// # Errors
    /// Fails if the description is not plausible or the duty is out of range.
    pub fn new(board: Board, given: Given) -> Result<Self, GivenError> {
        if !board.is_plausible() {
            return Err(GivenError::Board);
        }
        let least = (3 * duty_of(&board, u32::from(board.dead_time_ns))).max(1);
        if !(least..=QUARTER).contains(&given.duty.to_bits()) {
            return Err(GivenError::Duty(given.duty.to_bits(), least, QUARTER));
        }
        Ok(Self {
            board,
            given,
            stage: Stage::Off,
            ticks: 0,
            sums: Sums::default(),
            search: 0,
            halls: [0; 6],
            driven: 0,
            findings: [None; FINDINGS],
        })
    }

    /// Findings so far, in the order in which they were made.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().flatten()
    }

    /// Returns whether the check has come to its end, or was stopped by a finding that is wrong.
    pub fn is_done(&self) -> bool {
        self.stage == Stage::Done
    }

    /// One control tick. The samples are those that the command before asked for.
    pub fn step(&mut self, samples: &Samples) -> PwmCommand {
        self.ticks += 1;
        match self.stage {
            Stage::Off => self.off(samples),
            Stage::Leg(leg) => self.leg(leg, samples),
            Stage::DeadTime => self.dead_time(samples),
            Stage::Place(place) => self.place(place, samples),
            Stage::Done => {}
        }
        self.guard(samples);
        self.command()
    }

    fn command(&self) -> PwmCommand {
        let (step, duty) = match self.stage {
            Stage::Off | Stage::Done => (Step::Coast, Duty::from_bits(0)),
            Stage::Leg(leg) => (LEGS[usize::from(leg % 3)], self.given.duty),
            Stage::DeadTime => (Step::LockA, Duty::from_bits(self.search)),
            Stage::Place(place) => (LOCKS[usize::from(place % 6)], self.given.duty),
        };
        PwmCommand {
            duty,
            rectification: Rectification::Synchronous,
            sample_at: 0,
            sample_mode: SampleMode::OnTime,
            step,
            commutations: Commutations::NONE,
        }
    }

    /// Turns the bridge off when more current flows than was given.
    fn guard(&mut self, samples: &Samples) {
        if matches!(self.stage, Stage::Off | Stage::Done) {
            return;
        }
        let channel = self.board.front_end.bus_current;
        let codes = i64::from(samples.bus_current) - i64::from(channel.zero);
        let measured = (codes * i64::from(channel.micro_per_code) / 1000) as i32;
        let limit = ((i64::from(self.given.current_max.to_bits()) * 1000) >> 16) as u32;
        if measured.unsigned_abs() > limit {
            self.note(Check::CurrentLimit, None, measured, 0, limit);
        }
    }

    fn off(&mut self, samples: &Samples) {
        let settled = self.board.tick_rate / 10;
        if self.ticks > settled {
            self.sums.add(samples);
        }
        if self.ticks < 2 * settled {
            return;
        }
        let (sums, FrontEnd { bus_voltage, bus_current, .. }) = (self.sums, self.board.front_end);
        self.begin(Stage::Leg(0));
        let zero = (sums.current / sums.ticks.max(1)) as i32;
        self.note(Check::CurrentZero, None, zero, bus_current.zero.into(), ZERO_CODES);
        let supply = ((i64::from(self.given.supply.to_bits()) * 1000) >> 16) as i32;
        self.note(Check::BusVoltage, None, sums.milli(sums.bus, bus_voltage), supply, percent(supply));
    }

    fn leg(&mut self, leg: u8, samples: &Samples) {
        if self.ticks > LOCK_TICKS {
            self.sums.add(samples);
        }
        if self.ticks < 2 * LOCK_TICKS {
            return;
        }
        let (sums, front_end) = (self.sums, self.board.front_end);
        self.begin(if leg < 2 { Stage::Leg(leg + 1) } else { Stage::DeadTime });
        let bus = sums.milli(sums.bus, front_end.bus_voltage);
        let terminals = sums.terminals.map(|sum| sums.milli(sum, front_end.phase_voltage));
        let mut high = (0..3).zip(terminals).filter(|(_, volts)| *volts > bus / 2);
        // A single one follows, else none is the right one.
        let follows = match (high.next(), high.next()) {
            (Some((terminal, _)), None) => terminal,
            _ => -1,
        };
        self.note(Check::PhaseOrder, Some(leg), follows, leg.into(), 0);
        let volts = terminals[usize::from(leg % 3)];
        self.note(Check::TerminalVoltage, Some(leg), volts, bus, percent(bus));
    }

    /// The high side comes a dead time after the on-time begins, and the sample is taken in its middle: the
    /// terminal is high there as soon as half of the on-time is longer than the dead time.
    fn dead_time(&mut self, samples: &Samples) {
        // The current of the lock before would hold the terminal up.
        if self.ticks <= self.board.tick_rate / 100 {
            return;
        }
        let FrontEnd { bus_voltage, phase_voltage, .. } = self.board.front_end;
        let micro = |code: u16, channel: Channel| i64::from(code) * i64::from(channel.micro_per_code);
        let follows =
            micro(samples.phase_voltage[0], phase_voltage) > micro(samples.bus_voltage, bus_voltage) / 2;
        if follows || self.search >= QUARTER {
            let measured = ns_of(&self.board, self.search / 2);
            self.begin(if self.given.motor { Stage::Place(0) } else { Stage::Done });
            self.note(Check::DeadTime, Some(0), measured, self.board.dead_time_ns.into(), DEAD_TIME_NS);
        } else {
            self.search += duty_of(&self.board, DEAD_TIME_NS / 10).max(1);
        }
    }

    /// The field stands at each place for a quarter of a second.
    fn place(&mut self, place: u8, samples: &Samples) {
        let stand = self.board.tick_rate / 4;
        if self.ticks > stand / 2 {
            self.sums.add(samples);
        }
        if self.ticks < stand {
            return;
        }
        let sums = self.sums;
        self.begin(if place + 1 < PLACES { Stage::Place(place + 1) } else { Stage::Done });
        if place < PLACES / 2 {
            return;
        }
        self.halls[usize::from(place % 6)] = samples.hall & 7;
        self.driven += sums.milli(sums.current, self.board.front_end.bus_current);
        if place + 1 == PLACES {
            self.judge_places();
        }
    }

    fn judge_places(&mut self) {
        let mean = self.driven / 6;
        self.note(Check::CurrentSign, None, mean.min(0), 0, SIGN_MA);
        let seen = self.halls.iter().fold(0_u8, |seen, code| seen | 1 << code);
        self.note(Check::HallLines, None, seen.count_ones() as i32, 6, 0);
        let (order, polarity) = match wiring(self.halls) {
            Some(HallWiring { order, polarity, .. }) => (order.into(), polarity.into()),
            None => (-1, 0),
        };
        self.note(Check::HallOrder, None, order, 0, 0);
        self.note(Check::HallPolarity, None, polarity, 0, 0);
    }

    fn begin(&mut self, stage: Stage) {
        (self.stage, self.ticks, self.sums) = (stage, 0, Sums::default());
    }

    fn note(&mut self, check: Check, phase: Option<u8>, measured: i32, expected: i32, tolerance: u32) {
        let finding = Finding { check, phase, measured, expected, tolerance };
        if let Some(place) = self.findings.iter_mut().find(|place| place.is_none()) {
            *place = Some(finding);
        }
        if !finding.passes() {
            self.stage = Stage::Done;
        }
    }
}

/// The locks that switch one leg alone.
const LEGS: [Step; 3] = [Step::LockA, Step::LockB, Step::LockC];

/// Wiring that explains the codes at 0, 60 to 300 degrees; each is the middle of a sector.
fn wiring(halls: [u8; 6]) -> Option<HallWiring> {
    (0..48_u8).map(|number| HallWiring { order: number / 8, polarity: number % 8, offset: 0 }).find(
        |wiring| {
            let sectors = sectors(*wiring);
            // Sector 0 is about 60 degrees.
            (0..6_u8)
                .zip(halls)
                .all(|(place, code)| sectors.get(usize::from(code)) == Some(&((place + 5) % 6)))
        },
    )
}

const fn percent(milli: i32) -> u32 {
    (milli / 100 * SCALE_PERCENT).unsigned_abs()
}

/// Duty of so many ns, 1/32 768.
fn duty_of(board: &Board, ns: u32) -> u16 {
    let duty = ((u64::from(ns) * u64::from(board.tick_rate)) << 15) / 1_000_000_000;
    duty.min(1 << 15) as u16
}

/// The ns of a duty.
fn ns_of(board: &Board, duty: u16) -> i32 {
    ((u64::from(duty) * 1_000_000_000 / u64::from(board.tick_rate)) >> 15) as i32
}
