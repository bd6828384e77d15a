//! Expected and actual results of a run.

use super::scenario::within;
use narx_core::bus::Id;
use narx_core::motor::guard::fault::{Cause, FaultWord};
use narx_core::motor::machine::event::{HallCalibration, Refusal, Status};
use narx_core::motor::machine::state::State;
use serde::Deserialize;
use std::collections::{BTreeSet, VecDeque};

/// Expected results of a run.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// States in order, from power-up to the end.
    pub states: Vec<State>,
    /// Names of all bits that were set in the fault word at any time.
    #[serde(default)]
    pub faults: Vec<String>,
    /// Extended fault codes in order.
    #[serde(default)]
    pub codes: Vec<u16>,
    /// Refusals of a start in order.
    #[serde(default)]
    pub refusals: Vec<Refusal>,
    /// Speed at the end.
    pub speed: Option<Speed>,
    /// Result of a hall calibration.
    pub wiring: Option<Wiring>,
    /// Identifiers that nodes other than the master must have sent, in candump's form.
    #[serde(default)]
    pub sent: Vec<String>,
}

/// Mean speed of the last 0.1 s.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Speed {
    /// Mechanical rpm, negative in reverse.
    pub rpm: f64,
    /// Largest difference, per cent of the speed.
    pub within: f64,
}

/// Wiring that a hall calibration finds.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wiring {
    /// Order of the lines, parameter 262.
    pub order: u8,
    /// Polarity of the lines, parameter 263.
    pub polarity: u8,
    /// Offset, electrical degrees.
    pub offset_deg: f64,
    /// Largest difference of the offset, degrees.
    pub within_deg: f64,
}

/// Content of the drive's reports so far.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Control ticks over which the final speed is averaged.
    window: u64,
    /// States in order.
    pub states: Vec<State>,
    /// Every fault bit so far.
    pub faults: FaultWord,
    /// Extended fault codes in order.
    pub codes: Vec<u16>,
    /// Refusals in order.
    pub refusals: Vec<Refusal>,
    /// The last result of a calibration.
    pub calibration: HallCalibration,
    /// Tick and estimated electrical speed (rev/s) of the last 0.1 s.
    speeds: VecDeque<(u64, f64)>,
    code: u16,
    refusal: Refusal,
    /// Identifiers that nodes other than the master have sent.
    pub sent: BTreeSet<String>,
}

/// Number of ticks over which the final speed is averaged, 0.1 s, at this tick rate, Hz.
pub(super) const fn window(tick_rate: u32) -> u64 {
    tick_rate as u64 / 10
}

impl Seen {
    /// Nothing so far, of a drive with this tick rate, Hz.
    pub fn new(tick_rate: u32) -> Self {
        Self {
            window: window(tick_rate),
            states: Vec::new(),
            faults: FaultWord::empty(),
            codes: Vec::new(),
            refusals: Vec::new(),
            calibration: HallCalibration::default(),
            speeds: VecDeque::new(),
            code: 0,
            refusal: Refusal::default(),
            sent: BTreeSet::new(),
        }
    }

    /// Takes a report.
    pub fn note(&mut self, status: &Status) {
        if self.states.last() != Some(&status.state) {
            self.states.push(status.state);
        }
        self.faults |= status.faults;
        if status.extended_code != self.code && status.extended_code != 0 {
            self.codes.push(status.extended_code);
        }
        if status.refusal != self.refusal && status.refusal != Refusal::None {
            self.refusals.push(status.refusal);
        }
        (self.code, self.refusal) = (status.extended_code, status.refusal);
        self.calibration = status.hall_calibration;
        self.speeds.push_back((status.tick, f64::from(status.speed_hall.to_bits()) / 65_536.0));
        while self.speeds.front().is_some_and(|(tick, _)| tick + self.window < status.tick) {
            self.speeds.pop_front();
        }
    }

    /// Takes the identifier of a frame that was not the master's.
    pub fn note_sent(&mut self, id: Id) {
        self.sent.insert(match id {
            Id::Standard { raw, .. } => format!("{raw:03X}"),
            Id::Extended { raw, .. } => format!("{raw:08X}"),
        });
    }

    /// Mean estimated electrical speed of the last 0.1 s, rev/s.
    pub fn electrical_speed(&self) -> f64 {
        self.speeds.iter().map(|(_, speed)| speed).sum::<f64>() / self.speeds.len().max(1) as f64
    }
}

impl Expect {
    /// Checks that names and codes exist, and that tolerances are possible.
    pub(super) fn check(&self) -> Result<(), String> {
        self.fault_word()?;
        for code in &self.codes {
            if !Cause::TABLE.iter().any(|row| row.cause as u16 == *code) {
                return Err(format!(
                    "expect.codes = {code:#06x}: no such extended fault code; PROTOCOL.md, section 4"
                ));
            }
        }
        if let Some(speed) = &self.speed {
            within("expect.speed.rpm", speed.rpm, -65535.0, 65535.0, "rpm")?;
            within("expect.speed.within", speed.within, 0.0, 10.0, "%")?;
        }
        if let Some(wiring) = &self.wiring {
            within("expect.wiring.within_deg", wiring.within_deg, 0.0, 30.0, "degrees")?;
        }
        Ok(())
    }

    fn fault_word(&self) -> Result<FaultWord, String> {
        let mut word = FaultWord::empty();
        for name in &self.faults {
            word |= FaultWord::from_name(name).ok_or_else(|| {
                let names: Vec<&str> = FaultWord::all().iter_names().map(|(name, _)| name).collect();
                format!("expect.faults = \"{name}\": unknown; one of {}", names.join(", "))
            })?;
        }
        Ok(word)
    }

    /// Returns the deviations from the expected results; none if all match. `speed` is the shaft's mean over
    /// the last 0.1 s in mechanical rpm, if it is known.
    pub fn misses(&self, seen: &Seen, speed: Option<f64>) -> Vec<String> {
        let mut misses = Vec::new();
        let mut differs = |what: &str, found: String, expected: String| {
            if found != expected {
                misses.push(format!("{what} {found}, expected {expected}"));
            }
        };
        let hex = |codes: &[u16]| {
            format!("{:?}", codes.iter().map(|code| format!("{code:04X}h")).collect::<Vec<_>>())
        };
        differs("states", format!("{:?}", seen.states), format!("{:?}", self.states));
        differs("codes", hex(&seen.codes), hex(&self.codes));
        differs("refusals", format!("{:?}", seen.refusals), format!("{:?}", self.refusals));
        let silent: Vec<&String> = self.sent.iter().filter(|id| !seen.sent.contains(*id)).collect();
        differs("not sent:", format!("{silent:?}"), "[]".into());
        let faults = self.fault_word().unwrap_or(FaultWord::all());
        differs("faults", format!("{:?}", seen.faults), format!("{faults:?}"));
        if let (Some(expected), Some(found)) = (self.speed, speed)
            && exceeds((found - expected.rpm).abs(), expected.within / 100.0 * expected.rpm.abs())
        {
            misses.push(format!(
                "speed {found:.1} rpm, expected {} within {} %",
                expected.rpm, expected.within
            ));
        }
        if let Some(expected) = self.wiring
            && !expected.is(seen.calibration)
        {
            misses.push(format!("calibration {:?}, expected {expected:?}", seen.calibration));
        }
        misses
    }
}

impl Wiring {
    fn is(&self, found: HallCalibration) -> bool {
        let HallCalibration::Done(found) = found else { return false };
        let offset = f64::from(found.offset) * 360.0 / 65_536.0;
        (found.order, found.polarity) == (self.order, self.polarity)
            && (offset - self.offset_deg).abs() <= self.within_deg
    }
}

/// Returns whether a value exceeds a limit; NaN exceeds every limit.
fn exceeds(value: f64, limit: f64) -> bool {
    value.is_nan() || value > limit
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(tick: u64, state: State) -> Status {
        Status { tick, state, ..Status::default() }
    }

    fn expect(states: &[State]) -> Expect {
        Expect {
            states: states.to_vec(),
            faults: Vec::new(),
            codes: Vec::new(),
            refusals: Vec::new(),
            speed: None,
            wiring: None,
            sent: Vec::new(),
        }
    }

    /// Every difference is named.
    #[test]
    fn every_difference_is_a_miss() {
        let mut seen = Seen::new(10_000);
        seen.note(&status(1, State::Initialization));
        seen.note(&status(2, State::Standby));
        seen.note(&status(3, State::Standby));
        let good = expect(&[State::Initialization, State::Standby]);
        assert_eq!(good.misses(&seen, None), Vec::<String>::new());
        let speed = Speed { rpm: 100.0, within: 1.0 };
        let wiring = Wiring { order: 0, polarity: 0, offset_deg: 0.0, within_deg: 1.0 };
        for (wrong, said) in [
            (expect(&[State::Standby]), "states"),
            (Expect { faults: vec!["OVER_VOLTAGE".into()], ..good.clone() }, "faults"),
            (Expect { codes: vec![0x0201], ..good.clone() }, "codes"),
            (Expect { refusals: vec![Refusal::NoMode], ..good.clone() }, "refusals"),
            (Expect { speed: Some(speed), ..good.clone() }, "speed"),
            (Expect { wiring: Some(wiring), ..good.clone() }, "calibration"),
        ] {
            let misses = wrong.misses(&seen, Some(98.9));
            assert!(misses.len() == 1 && misses[0].starts_with(said), "{misses:?}");
        }
        let near = Expect { speed: Some(speed), ..good };
        assert!(near.misses(&seen, Some(99.1)).is_empty());
        assert_eq!(near.misses(&seen, Some(f64::NAN)).len(), 1);
    }
}
