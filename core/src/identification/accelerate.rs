//! A ramp of the speed, twice, with a coast between: inertia and friction. Then the hall sensors, on request.

use super::balance::Balance;
use super::coast::Coast;
use super::commission::MECHANICAL_TIME;
use super::script::Action;
use super::{Found, Identification, IdentificationError, MARGIN, SPIN, Stage, is_open_phase};
use crate::commissioning::Mode;
use crate::dictionary::{engineering, number};
use crate::master::Master;
use crate::motor::signal::Signal;
use libm::{fmax, fmin, round};

/// Electrical revolutions that the speed loop takes to follow its ramp.
const FOLLOWS: f64 = 4.0;
/// Samples of a third at the speed of the stop: few show a longer part of the coast.
const FEW_SAMPLES: f64 = 7.0;
/// The back-EMF constant of the driven motor over that of the coasting one. A winding whose current takes a
/// sector to rise seems to have a larger one: commutation takes part of the voltage.
const AGREES: core::ops::RangeInclusive<f64> = 0.85..=1.45;
/// Signals of an acceleration.
const DRIVEN: [Signal; 4] = [Signal::SpeedSensorless, Signal::BusVoltage, Signal::BusCurrent, Signal::Duty];

impl Identification {
    /// A step of the speed up to `rpm`, recorded; then a coasting rotor, recorded.
    pub(super) fn accelerate(&mut self, rpm: f64) -> Result<(), IdentificationError> {
        let commissioning = self.commission(Mode::Sensorless)?;
        let fast = round(fmin(rpm, commissioning.speed_max));
        let slow = round(fmax(fast / 3.0, commissioning.speed_min));
        if slow >= 0.8 * fast {
            return Err(IdentificationError::NoRoom { slow, fast });
        }
        self.found.speed = fast;
        // The record is as long as the ramp of the set-point, half as much, and what the speed loop is late.
        let rate = engineering::value(&commissioning.parameters, number::SPEED_RATE).unwrap_or(1000.0);
        let rows = self.found.room / 4;
        let turn = 60.0 / (slow * f64::from(self.found.pole_pairs));
        let length = 1.5 * (fast - slow) / rate + fmax(0.1, FOLLOWS * turn);
        let patience = if self.failed == 0 { SPIN } else { 2 * SPIN };
        let prescaler = fmax(1.0, round(length / (f64::from(rows) * self.found.period))) as u16;
        self.script.add(&[
            Action::Start(slow as i32),
            Action::Settle { rpm: slow, within: patience },
            Action::arm_forced(&DRIVEN, rows, prescaler),
            Action::Force,
            Action::Wait(MARGIN),
            Action::Speed(fast as u16),
            Action::AwaitRecord,
            Action::Download(u32::from(rows) * 4),
        ]);
        self.script.record.begin(&DRIVEN, f64::from(prescaler) * self.found.period);
        Ok(())
    }

    /// The acceleration is recorded, then the coasting rotor: inertia and friction. Then a second
    /// acceleration, with gains that fit them.
    pub(super) fn accelerated(&mut self, master: &mut Master) -> Result<(), IdentificationError> {
        let unsteady = IdentificationError::Unsteady(self.stage);
        let Found { winding: Some(winding), coast: Some(coast), channel, period, .. } = self.found else {
            return Err(unsteady);
        };
        self.round += 1;
        if self.round == 1 {
            return self.accelerate(self.found.speed);
        }
        let record = &self.script.record;
        if let Some(balance) = self.found.balance.take() {
            let coast = Coast::of(record)
                .filter(|seen| self.agrees(seen, &balance))
                .map_or(coast, |seen| coast.with(seen));
            self.found.coast = Some(coast);
            self.found.torque_constant = coast.torque_constant(self.found.pole_pairs.into());
            self.found.driven = Some(balance.solve(&coast).ok_or(unsteady)?);
            return self.accelerate(self.found.speed);
        }
        let balance = Balance::of(record, &winding, &coast, channel, self.found.pole_pairs.into(), period)
            .ok_or(unsteady)?;
        if !self.agrees(&coast, &balance) {
            return Err(unsteady);
        }
        let Some(before) = self.found.driven else {
            self.found.balance = Some(balance);
            self.script.add(&[Action::Settle { rpm: self.found.speed, within: SPIN }]);
            self.coast(FEW_SAMPLES);
            return Ok(());
        };
        self.found.driven = Some(before.mean(balance.solve(&coast).ok_or(unsteady)?));
        self.calibrate(master)
    }

    /// An acceleration has failed. If it was the second, the first one tells inertia and friction, less
    /// surely, unless a phase is open. Else another try, as if the rotor were lighter or heavier.
    pub(super) fn accelerate_again(
        &mut self,
        master: &mut Master,
        error: IdentificationError,
    ) -> Result<(), IdentificationError> {
        if let Some(driven) = self.found.driven
            && !is_open_phase(&error)
        {
            self.script.give_up(master);
            self.found.driven = Some(driven.alone());
            return self.calibrate(master);
        }
        self.failed += 1;
        if self.failed >= MECHANICAL_TIME.len() {
            return Err(error);
        }
        self.guess += 1;
        (self.round, self.found.balance) = (0, None);
        self.script.give_up(master);
        Ok(())
    }

    /// Inertia and friction are known: now the hall sensors, if they are asked for.
    fn calibrate(&mut self, master: &mut Master) -> Result<(), IdentificationError> {
        if !self.asked.halls {
            self.conclude(master);
            return Ok(());
        }
        self.stage = Stage::Calibrates;
        self.script.add(&[Action::Stop]);
        self.commission(Mode::Hall)?;
        self.script.add(&[
            Action::CalibrateHall,
            Action::Read(number::HALL_ORDER),
            Action::Read(number::HALL_POLARITY),
            Action::Read(number::HALL_OFFSET_ANGLE),
        ]);
        Ok(())
    }

    /// Two ways to the same constant: what was recorded fits a motor if they agree.
    fn agrees(&self, coast: &Coast, balance: &Balance) -> bool {
        let (constant, _) = coast.torque_constant(self.found.pole_pairs.into());
        AGREES.contains(&(balance.torque_constant / constant))
    }
}
