//! What the scope sees of the drive.

use super::Drive;
use crate::motor::fault::FaultWord;
use crate::motor::samples::Samples;
use crate::motor::signal::{Signal, SpeedScale};

impl Drive {
    /// FAULT_WORD: what is present or latched.
    pub fn faults(&self) -> FaultWord {
        self.protection.word()
    }

    /// The last step was not one that looks at everything.
    pub(crate) const fn was_calm(&self) -> bool {
        !self.machine.state().is_driving() || self.calm.slept() > 0
    }

    /// Samples of as many `signals` as `words` has room for, as of the last step, Q3.12 of their bases.
    #[inline]
    pub(crate) fn sample(&self, signals: &[Signal], speed: SpeedScale, samples: &Samples, words: &mut [u16]) {
        for (word, signal) in words.iter_mut().zip(signals) {
            *word = self.sample_of(*signal, speed, samples) as u16;
        }
    }

    /// Sample of one signal.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn sample_of(&self, signal: Signal, speed: SpeedScale, samples: &Samples) -> i16 {
        self.signal(signal, speed, samples).clamp(i16::MIN.into(), i16::MAX.into()) as i16
    }

    /// One of them. Bases are chosen so that a shift does: 16 V, 2 A, 64 W, one turn. Within a loop the compiler would compute every
    /// signal there is before it, and bound each in a way of its own.
    #[inline(never)]
    fn signal(&self, signal: Signal, speed: SpeedScale, samples: &Samples) -> i32 {
        let terminal = |phase: usize| {
            let code = samples.phase_voltage.get(phase).copied().unwrap_or(0);
            self.coefficients.measurement.phase_voltage.convert(code) >> 8
        };
        match signal {
            Signal::SetPoint => speed.apply(self.setpoint()),
            Signal::SpeedSensorless => speed.apply(self.speed_sensorless()),
            Signal::SpeedHall => speed.apply(self.rotor.hall_speed().to_bits()),
            Signal::BusVoltage => self.measurement.bus_voltage() >> 8,
            Signal::BusCurrent => self.measurement.bus_current() >> 5,
            Signal::Power => {
                let power =
                    i64::from(self.measurement.bus_voltage()) * i64::from(self.measurement.bus_current());
                (power >> 26) as i32
            }
            Signal::TerminalA => terminal(0),
            Signal::TerminalB => terminal(1),
            Signal::TerminalC => terminal(2),
            Signal::Duty => i32::from(self.applied.duty.to_bits()) >> 3,
            Signal::Angle => (self.angle_now() >> 20) as i32,
            Signal::State => (self.machine.state() as i32) << 12,
            Signal::Limiter => (self.limiter() as i32) << 11,
            Signal::Step => (self.applied.step as i32) << 11,
            Signal::Hall => i32::from(samples.hall) << 12,
            Signal::Crossing => (self.sensorless.why().0 as i32) << 12,
            Signal::CrossingMargin => i32::from(self.sensorless.why().1) >> 1,
            Signal::LoopVoltage => self.control.speed_voltage() >> 8,
            Signal::PhaseCurrent => self.control.phase_current() >> 5,
            Signal::PeriodCurrent => {
                self.measurement.bus_current_of(&self.coefficients.measurement, samples) >> 5
            }
            Signal::Fault => match self.protection.word().bits() {
                0 => -1 << 10,
                word => (word.trailing_zeros() as i32) << 10,
            },
            Signal::Inputs => i32::from(samples.lines.bits()) << 11,
        }
    }

    /// Electrical angle that the commutation uses, u32 turn: an estimator that sleeps would have turned it on.
    #[inline]
    fn angle_now(&self) -> u32 {
        let (angle, speed) = self.place();
        angle.wrapping_add((speed as u32).wrapping_mul(self.calm.slept()))
    }
}
