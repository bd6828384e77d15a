//! Hall calibration: turns the field slowly one electrical revolution each way and finds from the edges which
//! line is which (order), which are inverted (polarity) and how far they are turned (offset).
//!
//! The field's angle is not a phase current's but the angle at which a resting rotor settles. Friction makes
//! the rotor lag; averaged over both directions the lag cancels. Between the six locks, which settle 60
//! degrees apart, the field moves by switching between two neighbours, tick by tick. No leg ever floats, so
//! voltages average as vectors: within 1.1 degrees of linear on a sinusoidal motor and 2.1 on a trapezoidal
//! one. (Steps between the locks would halve the distance, but the leg that floats empties its current into a
//! diode, at a lock voltage of the size of the diode's drop.)

use super::hall::{HallWiring, sectors};
use crate::motor::commutate::commutation::{LOCKS, Step};
use crate::motor::gain::Gain;
use serde::{Deserialize, Serialize};

/// Outcome of a hall calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum HallCalibration {
    /// None was run.
    #[default]
    None,
    /// Running now.
    Running,
    /// Order, polarity and offset found.
    Done(HallWiring),
    /// The sensors did not change as three lines of one rotor do, or the two directions disagree.
    Failed,
}

/// Coefficients of the calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct HallCalibrationCoefficients {
    /// Speed of the field, 2^-32 turn a tick: half a revolution a second.
    pub speed: u32,
    /// The rotor lock level (parameter 89).
    pub level: i32,
}

impl HallCalibrationCoefficients {
    /// Half an electrical revolution a second at `turns` (2^-32 turn a tick per raw rev/s).
    pub fn new(turns: Gain, level: i32) -> Self {
        Self { speed: turns.apply32(1 << 15).unsigned_abs(), level }
    }
}

/// A quarter turn to take up the slack, then the revolution that counts.
const LEAD: u64 = 1 << 30;
const REVOLUTION: u64 = 1 << 32;
/// A line's centre may differ from its place by this much after the common offset is taken away: 20 degrees.
const SPREAD_MAX: i32 = 3_641;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Pass {
    #[default]
    Forward,
    Reverse,
    /// Trying wiring number 0..=47, one a tick.
    Fit(u8),
    Finished,
}

/// Angles (u16 turns) at which one line rose and fell in one pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
struct LineEdges {
    rise: u16,
    fall: u16,
    rises: u8,
    falls: u8,
}

/// State of a calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HallCalibrator {
    pass: Pass,
    /// Angle that this pass has turned, 2^-32 turn.
    travelled: u64,
    /// Sigma-delta remainder between two neighbouring patterns.
    dither: u32,
    code: u8,
    lines: [[LineEdges; 3]; 2],
    /// Smallest |offset| so far with its wiring.
    best: Option<HallWiring>,
}

impl HallCalibrator {
    /// The pattern that rotor lock holds before a calibration starts: settles at 0 degrees.
    pub const LOCK: Step = Step::LockBC;

    /// Starts with the rotor locked at 0 degrees; `code` is the present raw hall code.
    pub fn start(&mut self, code: u8) {
        *self = Self { code, ..Self::default() };
    }

    /// One tick: the pattern to apply, and how it stands.
    pub fn step(&mut self, c: &HallCalibrationCoefficients, code: u8) -> (Step, HallCalibration) {
        let code = code & 7;
        match self.pass {
            Pass::Forward | Pass::Reverse => {
                self.note(code);
                self.travelled += c.speed as u64;
                if self.travelled >= LEAD + REVOLUTION {
                    self.travelled = 0;
                    self.pass = if self.pass == Pass::Forward { Pass::Reverse } else { Pass::Fit(0) };
                }
            }
            Pass::Fit(number) => {
                self.fit(number);
                self.pass = if number >= 47 { Pass::Finished } else { Pass::Fit(number + 1) };
            }
            Pass::Finished => {
                let result = self.best.map_or(HallCalibration::Failed, HallCalibration::Done);
                return (Step::Coast, result);
            }
        }
        (self.pattern(), HallCalibration::Running)
    }

    /// Angle at which the rotor settles now, u32 turn. The reverse pass starts where the forward one ended, a
    /// quarter turn beyond a revolution.
    fn angle(&self) -> u32 {
        match self.pass {
            Pass::Forward => self.travelled as u32,
            _ => (LEAD as u32).wrapping_sub(self.travelled as u32),
        }
    }

    /// One of the two patterns that settle at or next to the angle, as often as each is near.
    fn pattern(&mut self) -> Step {
        let sixths = self.angle() as u64 * 6;
        let (index, fraction) = ((sixths >> 32) as usize, sixths as u32);
        let (dither, carry) = self.dither.overflowing_add(fraction);
        self.dither = dither;
        LOCKS[(index + carry as usize) % 6]
    }

    /// Remembers where each line changed during the revolution that counts.
    fn note(&mut self, code: u8) {
        let changed = core::mem::replace(&mut self.code, code) ^ code;
        if changed == 0 || self.travelled < LEAD {
            return;
        }
        let angle = (self.angle() >> 16) as u16;
        let reverse = self.pass == Pass::Reverse;
        for (line, edges) in self.lines[usize::from(reverse)].iter_mut().enumerate() {
            if changed & (1 << line) == 0 {
                continue;
            }
            // Turning backwards over the boundary where a line rises, it falls.
            if (code & (1 << line) != 0) != reverse {
                edges.rise = angle;
                edges.rises = edges.rises.saturating_add(1);
            } else {
                edges.fall = angle;
                edges.falls = edges.falls.saturating_add(1);
            }
        }
    }

    /// Tries one of the 48 wirings: 6 orders x 8 polarities.
    fn fit(&mut self, number: u8) {
        let wiring = HallWiring { order: number % 6, polarity: number / 6, offset: 0 };
        let Some(centres) = self.centres() else { return };
        let Some(offset) = offset_of(wiring, centres) else { return };
        if self.best.is_none_or(|best| offset.unsigned_abs() < best.offset.unsigned_abs()) {
            self.best = Some(HallWiring { offset, ..wiring });
        }
    }

    /// The middle of each line's high half, friction averaged out; `None` unless every line rose and fell
    /// once a pass.
    fn centres(&self) -> Option<[u16; 3]> {
        let [forward, reverse] = &self.lines;
        let mut centres = [0; 3];
        for ((centre, there), back) in centres.iter_mut().zip(forward).zip(reverse) {
            if [there.rises, there.falls, back.rises, back.falls] != [1; 4] {
                return None;
            }
            let rise = middle(there.rise, back.rise);
            let fall = middle(there.fall, back.fall);
            // From rise forward to fall the line is high.
            *centre = rise.wrapping_add(fall.wrapping_sub(rise) / 2);
        }
        Some(centres)
    }
}

/// Half way from `a` to `b` on the shorter side.
fn middle(a: u16, b: u16) -> u16 {
    a.wrapping_add((b.wrapping_sub(a) as i16 / 2) as u16)
}

/// The common offset of three line centres under a wiring; `None` if the lines disagree.
fn offset_of(wiring: HallWiring, centres: [u16; 3]) -> Option<i16> {
    let table = sectors(wiring);
    let mut deviations = [0_i16; 3];
    for (line, (deviation, centre)) in deviations.iter_mut().zip(centres).enumerate() {
        *deviation = centre.wrapping_sub(expected_centre(&table, line)?) as i16;
    }
    let [first, ..] = deviations;
    let from_first = deviations.map(|deviation| deviation.wrapping_sub(first) as i32);
    let mean = from_first.iter().sum::<i32>() / 3;
    let agree = from_first.iter().all(|deviation| (deviation - mean).abs() <= SPREAD_MAX);
    agree.then_some(first.wrapping_add(mean as i16))
}

/// Centre of a raw line's high half with this table: the middle of the three sectors in which it is high.
fn expected_centre(table: &[u8; 8], line: usize) -> Option<u16> {
    let mut high = [false; 6];
    for (code, sector) in table.iter().enumerate() {
        if let Some(slot) = high.get_mut(*sector as usize) {
            *slot = code & (1 << line) != 0;
        }
    }
    // The middle of three neighbours that are high, and only those.
    let middle = (0..6).find(|s| high[(s + 5) % 6] && high[*s] && high[(s + 1) % 6])?;
    // Sector s is centred on 60 + 60 s degrees.
    (high.iter().filter(|h| **h).count() == 3).then(|| (((middle as u32 + 1) * 65_536 / 6) & 0xFFFF) as u16)
}
