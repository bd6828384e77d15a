//! Signals of the drive for the scope.

use super::Drive;
use crate::motor::guard::fault::FaultWord;
use crate::motor::rotor::zero_crossing::Why;
use crate::motor::sense::samples::Samples;
use crate::motor::signal::{ShaftScale, Signal};
use crate::units::Duty;

impl Drive {
    /// FAULT_WORD: what is present or latched.
    pub fn faults(&self) -> FaultWord {
        self.protection.word()
    }

    /// Outcome of the last step's zero crossing, lag of the last accepted one behind its prediction (turn of
    /// 65 536), and number of accepted crossings.
    pub const fn crossing(&self) -> (Why, i16, u32) {
        self.rotor.sensorless.why()
    }

    /// Sample of a signal as of the last step, Q3.12 of its base in
    /// [`DRIVE_SIGNALS`](crate::motor::signal::DRIVE_SIGNALS): what a scope would record.
    pub fn signal(&self, signal: Signal, shaft: ShaftScale, samples: &Samples) -> i16 {
        self.sample(signal, shaft, samples) as i16
    }

    /// The last step asked no station, or the bridge is off: there is time for other work in this tick.
    pub(crate) fn has_time_to_spare(&self) -> bool {
        !self.machine.state().is_driving() || self.asked != self.now
    }

    /// Samples of four signals, as of the last step, Q3.12 of their bases. Not a loop: within one the
    /// compiler would compute every signal there is before it, or call each.
    #[inline]
    pub(crate) fn sample4(
        &self,
        signals: &[Signal; 4],
        shaft: ShaftScale,
        samples: &Samples,
        words: &mut [u16; 4],
    ) {
        let ([a, b, c, d], [to_a, to_b, to_c, to_d]) = (signals, words);
        *to_a = self.sample(*a, shaft, samples) as u16;
        *to_b = self.sample(*b, shaft, samples) as u16;
        *to_c = self.sample(*c, shaft, samples) as u16;
        *to_d = self.sample(*d, shaft, samples) as u16;
    }

    /// Sample of one signal. Bases are chosen so that a shift does: 16 V, 2 A, 64 W, one turn. What cannot
    /// leave the range is not bounded.
    #[inline]
    pub(crate) fn sample(&self, signal: Signal, shaft: ShaftScale, samples: &Samples) -> i32 {
        let terminal = |code| bounded(self.coefficients.measurement.phase_voltage.convert(code) >> 8);
        match signal {
            Signal::SetPoint => bounded(shaft.speed(self.setpoint())),
            Signal::SpeedSensorless => bounded(shaft.speed(self.speed_sensorless())),
            Signal::SpeedHall => {
                bounded(shaft.speed(self.rotor.hall_speed(&self.coefficients, self.now).to_bits()))
            }
            Signal::BusVoltage => bounded(self.measurement.bus_voltage() >> 8),
            Signal::BusCurrent => bounded(self.measurement.bus_current() >> 5),
            Signal::Power => {
                let (voltage, current) = (self.measurement.bus_voltage(), self.measurement.bus_current());
                bounded(((i64::from(voltage) * i64::from(current)) >> 26) as i32)
            }
            Signal::TerminalA => terminal(samples.phase_voltage[0]),
            Signal::TerminalB => terminal(samples.phase_voltage[1]),
            Signal::TerminalC => terminal(samples.phase_voltage[2]),
            Signal::Duty => i32::from(self.applied.duty.to_bits() >> 3),
            Signal::Angle => (self.angle() >> 20) as i32,
            Signal::State => (self.machine.state() as i32) << 12,
            Signal::Limiter => (self.limiter() as i32) << 11,
            Signal::Step => (self.applied.step as i32) << 11,
            Signal::Hall => bounded(i32::from(samples.hall) << 12),
            Signal::Crossing => (self.rotor.sensorless.why().0 as i32) << 12,
            Signal::CrossingMargin => i32::from(self.rotor.sensorless.why().1 >> 1),
            Signal::LoopVoltage => bounded(self.control.speed_voltage() >> 8),
            Signal::PhaseCurrent => bounded(self.control.phase_current() >> 5),
            Signal::PeriodCurrent => {
                bounded(self.measurement.bus_current_of(&self.coefficients.measurement, samples) >> 5)
            }
            Signal::Fault => match self.protection.word().bits() {
                0 => -1 << 10,
                word => (word.trailing_zeros() as i32) << 10,
            },
            Signal::Inputs => bounded(i32::from(samples.lines.bits()) << 11),
            Signal::Position => shaft.position(self.rotor.sectors()),
        }
    }

    /// Electrical angle that the commutation uses, u32 turn: extrapolated to `now`, also while the estimator
    /// is not asked.
    #[inline]
    pub(super) fn angle(&self) -> u32 {
        if let Some(lock) = self.applied.step.lock_angle()
            && self.control.output().duty != Duty::ZERO
        {
            return lock;
        }
        self.rotor.angle(self.now)
    }
}

#[inline]
fn bounded(value: i32) -> i32 {
    value.clamp(i16::MIN.into(), i16::MAX.into())
}
