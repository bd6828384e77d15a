//! From a demand (a level or a speed) to duty and rectification: speed loop, current limit, the smaller wins,
//! volts to duty.

pub mod limits;
pub mod pi;

mod coast;
mod coefficients;
mod steady;

use super::commutate::pwm::Rectification;
use super::control::limits::{CurrentLimit, Limiter};
use super::control::pi::Pi;
use super::ramp::Ramp;
use super::sense::measurement::{Measured, Measurement};
use crate::units::{Amps, Celsius, Duty};
use coast::{CATCH, Coasting, feeds};
use serde::{Deserialize, Serialize};
use steady::Steady;

pub use coefficients::{ControlCoefficients, ModeCoefficients};

/// The state's demand on the bridge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Demand {
    /// Bridge off.
    Off,
    /// A level (see [`ControlCoefficients::initial_level`]): rotor lock, open loop, calibration.
    Level(i32),
    /// A speed: closed loop. The voltage fades by so many 1/16, because the rotor's position is getting
    /// uncertain.
    Speed(u8),
}

/// Duty and freewheeling for the commutation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Duty from the next period, in the mean over the periods where it is below the shortest pulse.
    pub duty: Duty,
    /// Freewheeling from the next period.
    pub rectification: Rectification,
    /// The limit that bounds the duty.
    pub limiter: Limiter,
}

/// State of the control station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Control {
    speed: Pi,
    current: Pi,
    setpoint: Ramp,
    limit: CurrentLimit,
    /// Voltage that the last decision was asked for.
    wanted: i32,
    /// Output and error of the speed loop, held between milliseconds.
    speed_voltage: i32,
    speed_error: i32,
    /// Sum of speeds that lets the speed loop run less often at low speed, electrical rev/s.
    turn: i32,
    phase_current: i32,
    coasting: Option<Coasting>,
    /// Milliseconds for which a rotor that turned at the start, or while the bridge was off, is caught; 0
    /// once it is.
    catching: u16,
    /// The bridge was off in the midst of this episode.
    interrupted: bool,
    output: Output,
    steady: Steady,
}

/// Mean bus current beyond which diodes take over: -0.3 A.
const REGENERATING: i32 = -(1 << 16) * 3 / 10;
/// Mean bus current that is clearly forward: 50 mA.
const MOTORING: i32 = (1 << 16) / 20;

/// 500 rpm with 4 pole pairs (Table 2): from there on the speed loop runs every millisecond, raw electrical
/// rev/s.
const WHOLE: i32 = 33 << 16;

/// Below [`WHOLE`] the loop takes 30 turns in a revolution. In each the set-point falls by 1/512, which is
/// 6 % a revolution: its 16 extra bits, less 9.
const FALL: u32 = 16 - 9;

/// A current limit may take the duty back this many times faster than it rises.
const RETREAT: u16 = 8;

impl Control {
    /// A driven episode begins from standstill, or from `speed` (raw electrical rev/s) of a rotor that turns
    /// already: that one is caught with diodes, where no voltage is too small. Every controller continues
    /// from the first voltage (parameter 84) on this bus (raw I16F16 V).
    pub fn start(&mut self, c: &ControlCoefficients, speed: i32, bus_voltage: i32) {
        *self = Self { limit: self.limit, ..Self::default() };
        self.limit.start(&c.limits);
        self.setpoint.set(speed);
        self.take_over(c.volts(c.initial_level, bus_voltage));
        self.catching = if speed == 0 { 0 } else { CATCH };
        if self.catching == 0 {
            self.output.rectification = Rectification::Synchronous;
        }
    }

    /// Bumpless change from a level to the speed loop: every controller continues from `voltage` (what is
    /// [`applied`](Self::applied), or parameter 84), the set-point's ramp from the measured `speed` (raw
    /// electrical rev/s).
    pub fn hand_over(&mut self, speed: i32, voltage: i32) {
        self.setpoint.set(speed);
        self.speed_error = 0;
        (self.interrupted, self.catching, self.coasting) = (false, 0, None);
        self.take_over(voltage);
    }

    /// Estimated mean phase current as of the last millisecond, raw I16F16 A.
    pub const fn phase_current(&self) -> i32 {
        self.phase_current
    }

    /// Voltage that the last duty gives on this bus, raw I16F16 V.
    pub const fn applied(&self, c: &ControlCoefficients, bus_voltage: i32) -> i32 {
        share(bus_voltage, self.output.duty.to_bits().saturating_sub(self.lost_duty(c)))
    }

    /// Lets the next tick decide anew: something else than the samples has changed.
    pub const fn decide_anew(&mut self) {
        self.steady = Steady::NONE;
    }

    /// Every controller continues from `voltage`.
    fn take_over(&mut self, voltage: i32) {
        self.decide_anew();
        self.speed.wait(voltage);
        self.current.wait(voltage);
        self.speed_voltage = voltage;
    }

    /// Once a millisecond: the ratings. `turns`: the rotor is not known to stand.
    pub fn update_ratings(
        &mut self,
        c: &ControlCoefficients,
        measurement: &Measurement,
        temperature: Celsius,
        turns: bool,
    ) {
        let (voltage, current) = (measurement.bus_voltage(), measurement.bus_current());
        self.phase_current = per_duty(current, self.output.duty.to_bits());
        if self.limit.update(&c.limits, (voltage, current), self.phase_current, temperature, turns) {
            self.decide_anew();
        }
    }

    /// Once a millisecond in closed loop: the set-point's ramp, and the speed loop. Magnitudes in the
    /// direction of torque, raw I16F16 electrical rev/s; `target` is the set-point after saturation, and the
    /// rise towards it a millisecond, 16 extra bits.
    pub fn run_speed_loop(
        &mut self,
        c: &ControlCoefficients,
        mode: &ModeCoefficients,
        target: (i32, i64),
        speed: i32,
        (measurement, bus_current): (&Measurement, Amps),
    ) {
        if self.interrupted {
            return;
        }
        if self.catching > 1 {
            self.catching -= 1;
        }
        if self.coasting.is_some() {
            self.speed_error = self.advance_setpoint(target, speed, mode.sparse).saturating_sub(speed);
        } else if !mode.sparse || self.takes_turn(speed) {
            let ceiling = share(measurement.bus_voltage(), mode.duty_max);
            self.speed_error = self.advance_setpoint(target, speed, mode.sparse).saturating_sub(speed);
            self.speed_voltage = self.speed.step(&mode.speed, self.speed_error, 0, ceiling);
        }
        self.renew_steady(c, bus_current);
    }

    /// One tick with every limit in turn. `speed` is that of a closed loop, a magnitude in the direction of
    /// torque, raw I16F16 electrical rev/s.
    #[inline(never)]
    pub fn decide(
        &mut self,
        c: &ControlCoefficients,
        mode: &ModeCoefficients,
        demand: Demand,
        speed: i32,
        measured: &Measured,
        measurement: &Measurement,
    ) {
        self.decide_anew();
        let bus_voltage = measurement.bus_voltage();
        let (wanted, own) = match demand {
            Demand::Off => {
                (self.output, self.interrupted) = (Output::default(), true);
                self.steady = Steady::OFF;
                return;
            }
            Demand::Level(level) => (c.volts(level, bus_voltage), Limiter::Fixed),
            Demand::Speed(fade) => {
                let begins = self.speed_error < 0 && feeds(c, measured);
                let catches = self.catching > 0 || self.interrupted || self.coasting.is_some();
                if (begins || catches) && self.coasts(c, measured, measurement, speed) {
                    self.output = Output { limiter: Limiter::Return, ..Output::default() };
                    return;
                }
                match fade {
                    0 => (self.speed_voltage, Limiter::Speed),
                    _ => (self.faded(c, speed, fade), Limiter::Fade),
                }
            }
        };
        let (voltage, limiter) = self.limit_current(c, wanted, own, measured);
        self.apply(c, measurement.duty(voltage), mode.duty_max, limiter, measured);
        // The slew limit passes within a tick or two and is no reason to forget; maximum duty is the loop's
        // own ceiling.
        if limiter != own || own == Limiter::Fade {
            self.follow(c, mode, demand, measured);
        }
        self.wanted = wanted;
    }

    /// Something else than the speed loop decides: it goes along.
    fn follow(
        &mut self,
        c: &ControlCoefficients,
        mode: &ModeCoefficients,
        demand: Demand,
        measured: &Measured,
    ) {
        if let Demand::Speed(_) = demand {
            let applied = self.applied(c, measured.bus_voltage.to_bits());
            self.speed.track(&mode.speed, applied, self.speed_error, c.track);
        }
    }

    /// Fades the part of the voltage above back-EMF, and with it the torque: a voltage below back-EMF would
    /// brake the motor into the bus. If the back-EMF constant is unknown, all of the voltage fades.
    fn faded(&self, c: &ControlCoefficients, speed: i32, fade: u8) -> i32 {
        let back_emf = c.back_emf.apply32(speed).clamp(0, self.speed_voltage.max(0));
        back_emf + (self.speed_voltage - back_emf) / 16 * (16 - i32::from(fade.min(16)))
    }

    /// Set-point after its ramp, raw I16F16 electrical rev/s, a magnitude.
    pub const fn setpoint(&self) -> i32 {
        self.setpoint.value()
    }

    /// Voltage that the speed loop wants, raw I16F16 V.
    pub const fn speed_voltage(&self) -> i32 {
        self.speed_voltage
    }

    /// The command that was applied last.
    pub const fn output(&self) -> Output {
        self.output
    }

    /// Below the drive's range of speed crossings are so rare that the loop would integrate an old
    /// measurement over and over, until a light rotor stands: there it takes its turn less often, in
    /// proportion to the speed.
    const fn takes_turn(&mut self, speed: i32) -> bool {
        let share = if speed < WHOLE { speed } else { WHOLE };
        self.turn += if share > WHOLE / 8 { share } else { WHOLE / 8 };
        let due = self.turn >= WHOLE;
        if due {
            self.turn -= WHOLE;
        }
        due
    }

    /// The ramp waits while something else than the speed loop bounds a motor that lags behind: it must not
    /// run away from a speed that cannot follow. Where crossings are rare (`sparse`) it falls no faster than
    /// they can show, unless the motor is to stop: a rotor that is braked within a revolution stands before
    /// the loop knows.
    fn advance_setpoint(&mut self, (target, rate): (i32, i64), speed: i32, sparse: bool) -> i32 {
        let setpoint = self.setpoint.value();
        let falls = 0 < target && target < setpoint;
        let rate =
            if sparse && falls && setpoint < WHOLE { rate.min(i64::from(setpoint) << FALL) } else { rate };
        let lagging = target > setpoint && speed < setpoint;
        if lagging && !matches!(self.output.limiter, Limiter::Speed | Limiter::Off) {
            return setpoint;
        }
        self.setpoint.step(target, rate)
    }

    /// The wanted voltage, but no more than the current limiter allows. It looks at phase amperes, bus
    /// current over duty, so that its loop does not change with the duty.
    fn limit_current(
        &mut self,
        c: &ControlCoefficients,
        wanted: i32,
        own: Limiter,
        measured: &Measured,
    ) -> (i32, Limiter) {
        let duty = self.output.duty.to_bits();
        let ceiling = measured.bus_voltage.to_bits().max(0);
        let (bound, limiter) = self.limit.bound(duty.max(c.duty_min));
        // The limiter's output is at least its integrator, or the ceiling, while there is room: most ticks
        // need no division.
        let idle = bound >= measured.bus_current.to_bits() && self.current.is_at_least(wanted);
        if idle && wanted <= ceiling {
            self.current.wait(wanted.min(share(ceiling, duty.saturating_add(c.slew))));
            return (wanted, own);
        }
        let room = per_duty(bound.saturating_sub(measured.bus_current.to_bits()), duty);
        let most = self.current.step(&c.current, room, 0, ceiling);
        let (voltage, limiter) = if most < wanted { (most, limiter) } else { (wanted, own) };
        if most >= wanted {
            // Beside what the slew limit lets through: waiting further up it would come too late.
            self.current.wait(voltage.min(share(ceiling, duty.saturating_add(c.slew))));
        }
        (voltage, limiter)
    }

    /// Duty that the dead time takes from the terminals: with synchronous rectification the commanded duty
    /// must be this much larger. In diode mode only one switch works, and nothing is lost. The present
    /// rectification is that of the tick before: a change of it is compensated one tick late.
    pub const fn lost_duty(&self, c: &ControlCoefficients) -> u16 {
        if matches!(self.output.rectification, Rectification::Synchronous) { c.dead_time } else { 0 }
    }

    fn apply(
        &mut self,
        c: &ControlCoefficients,
        duty: Duty,
        duty_max: u16,
        limiter: Limiter,
        measured: &Measured,
    ) {
        let before = self.output.duty.to_bits();
        let lost = if duty.to_bits() > 0 { self.lost_duty(c) } else { 0 };
        let (mut next, mut limiter) = (duty.to_bits().saturating_add(lost), limiter);
        if next > duty_max {
            (next, limiter) = (duty_max, Limiter::Duty);
        }
        let current = matches!(
            limiter,
            Limiter::Current | Limiter::PhaseCurrent | Limiter::Power | Limiter::Temperature
        );
        let fall = if current { c.slew.saturating_mul(RETREAT) } else { c.slew };
        let slewed = next.min(before.saturating_add(c.slew)).max(before.saturating_sub(fall));
        if slewed != next {
            (next, limiter) = (slewed, Limiter::Slew);
        }
        let rectification = self.rectification(c, measured);
        self.output = Output { duty: Duty::from_bits(next), rectification, limiter };
    }

    /// Diodes while a rotor is caught, while the bus is full and the motor hardly draws from it, and while it
    /// is fed in earnest: current in a diode cannot reverse. Else the switches.
    fn rectification(&self, c: &ControlCoefficients, measured: &Measured) -> Rectification {
        let current = measured.bus_current_filtered.to_bits();
        let full = measured.bus_voltage.to_bits() > c.bus_guard && current < MOTORING;
        if self.catching > 0 || full || current < REGENERATING {
            Rectification::Diode
        } else {
            Rectification::Synchronous
        }
    }
}

/// `voltage x duty`.
const fn share(voltage: i32, duty: u16) -> i32 {
    let voltage = if voltage > 0 { voltage } else { 0 };
    ((voltage as i64 * duty as i64) >> 15) as i32
}

/// `current / duty`, raw I16F16: what a mean bus current is in the phase. Below 1/32 the duty counts as that,
/// so that noise is not blown up. 32-bit division, which the processor has.
fn per_duty(current: i32, duty: u16) -> i32 {
    let duty = i32::from(duty.max(1 << 10));
    let current = current.clamp(-(1 << 19), 1 << 19);
    ((current << 11) / duty) << 4
}
