//! A slow field that counts the pole pairs, then closed loop without sensors and a rotor that coasts: the
//! torque constant.

use super::coast::Coast;
use super::script::{self, Action};
use super::{Identification, IdentificationError, MARGIN, POLE_PAIRS, SPIN, SPINS, Stage};
use crate::commissioning::Mode;
use crate::dictionary::number;
use crate::master::Master;
use crate::motor::signal::Signal;
use core::f64::consts::TAU;
use libm::{fabs, fmax, fmin, round};

/// Share of the supply at which back-EMF is measured: half of the nominal speed at most.
const SHARE: f64 = 0.42;
/// Least share that is enough.
const ENOUGH: f64 = 0.33;
/// A rotor that shows no back-EMF may turn so many times faster.
const UNSEEN: f64 = 3.0;
/// While turns are counted, the field turns so many times a second: so slowly that an eye sees the mark pass.
const FIELD: f64 = 2.0;
/// Largest difference of a count from a whole number.
const UNCLEAR: f64 = 0.3;
/// Samples of a third at the speed of the stop: many show the back-EMF.
const MANY_SAMPLES: f64 = 16.0;
/// Signals of a rotor that coasts.
const TERMINALS: [Signal; 3] = [Signal::TerminalA, Signal::TerminalB, Signal::TerminalC];

impl Identification {
    /// The field turns slowly, at the last level, with one pole pair as far as the drive knows.
    pub(super) fn count(&mut self) -> Result<(), IdentificationError> {
        self.stage = Stage::Counts;
        self.set(number::MOTOR_POLE_PAIRS, 1.0)?;
        self.set(number::OPEN_LOOP_SPEED, 60.0 * FIELD)?;
        self.script.add(&[Action::Start(0), Action::Count, Action::Stop]);
        Ok(())
    }

    /// The turns are marked: so many times has the field turned for each.
    pub(super) fn counted(&mut self) -> Result<(), IdentificationError> {
        let counted = FIELD / f64::from(script::TURNS) * self.script.time_of_turns();
        let whole = round(counted) as u8;
        if fabs(counted - f64::from(whole)) > UNCLEAR || !POLE_PAIRS.contains(&whole) {
            return Err(IdentificationError::NotCounted { counted });
        }
        self.found.pole_pairs = whole;
        self.first_spin()
    }

    /// The first run: 50 electrical revolutions a second.
    pub(super) fn first_spin(&mut self) -> Result<(), IdentificationError> {
        self.stage = Stage::Spins;
        self.spin(50.0 * 60.0 / f64::from(self.found.pole_pairs))
    }

    /// Turns the rotor at a speed, rpm, and records its terminals after the stop.
    fn spin(&mut self, rpm: f64) -> Result<(), IdentificationError> {
        let commissioning = self.commission(Mode::Sensorless)?;
        let rpm = round(fmin(fmax(rpm, commissioning.speed_min), commissioning.speed_max));
        self.found.speed = rpm;
        self.script.add(&[Action::Start(rpm as i32), Action::Settle { rpm, within: SPIN }]);
        self.coast(MANY_SAMPLES);
        Ok(())
    }

    /// The bridge goes off: records the terminals of the coasting rotor.
    pub(super) fn coast(&mut self, samples: f64) {
        let third = 20.0 / (self.found.speed * f64::from(self.found.pole_pairs));
        let prescaler = fmax(1.0, libm::floor(third / (samples * self.found.period))) as u16;
        // The first one only shows how fast the motor may turn.
        let is_first = self.stage == Stage::Spins && self.round == 0;
        let rows = self.found.room / if is_first { 9 } else { 3 };
        self.script.add(&[
            Action::arm(&TERMINALS, rows, prescaler, 0),
            Action::Wait(MARGIN),
            Action::Stop,
            Action::AwaitRecord,
            Action::Download(u32::from(rows) * 3),
        ]);
        self.script.record.begin(&TERMINALS, f64::from(prescaler) * self.found.period);
    }

    /// A start has failed: another one, at another speed, as if the rotor were lighter or heavier. What an
    /// earlier coast seemed to tell is forgotten: the drive could not start with it.
    pub(super) fn spin_again(&mut self, master: &mut Master, error: IdentificationError) {
        (self.last, self.retries) = (Some(error), true);
        self.guess += 1;
        self.found.torque_constant = (0.0, 0.0);
        self.script.give_up(master);
        self.script.record.begin(&TERMINALS, 1.0);
    }

    /// A coasting rotor is recorded: a faster run, or what k is.
    pub(super) fn spun(&mut self, master: &mut Master) -> Result<(), IdentificationError> {
        self.round += 1;
        let poles = f64::from(self.found.pole_pairs);
        let coast = Coast::of(&self.script.record);
        let Some(coast) = coast else {
            if self.round >= SPINS {
                let unseen = IdentificationError::NoBackEmf { rpm: self.found.speed };
                return Err(self.last.unwrap_or(unseen));
            }
            return self.spin(UNSEEN * self.found.speed);
        };
        self.found.torque_constant = coast.torque_constant(poles);
        let (k, _) = self.found.torque_constant;
        let emf = k * coast.speed / poles;
        let most = SHARE * self.found.supply / k * 60.0 / TAU;
        let before = self.found.speed;
        if emf < ENOUGH * self.found.supply && self.round < SPINS {
            self.spin(fmin(3.0 * before, most))?;
            if self.found.speed > 1.1 * before {
                return Ok(());
            }
            // The drive turns no faster: this is what there is.
            self.script.drop_all(master);
        }
        (self.found.coast, self.stage, self.round, self.failed) = (Some(coast), Stage::Accelerates, 0, 0);
        self.found.speed = fmin(fmax(before, 1.0), most);
        Ok(())
    }
}
