//! From a demand (a level or a speed) to duty and rectification: speed loop, current limit, the smaller wins, volts to duty.

use super::gain::Gain;
use super::limits::Limiter;
use super::limits::{CurrentLimit, LimitCoefficients};
use super::measurement::{Measured, Measurement};
use super::pi::{Pi, PiGains};
use super::pwm::Rectification;
use super::ramp::Ramp;
use crate::units::{Celsius, Duty, saturate64};
use serde::{Deserialize, Serialize};

/// Coefficients of the control station. Volts, amperes and rev/s are raw I16F16, duties raw U1F15.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ControlCoefficients {
    /// Ticks in a millisecond.
    pub ticks_per_ms: u16,
    /// Bus current limiter, per tick.
    pub current: PiGains,
    /// Current ratings.
    pub limits: LimitCoefficients,
    /// Speed set-point ramp, electrical rev/s per millisecond with 16 extra bits (parameter 99).
    pub speed_rate: i64,
    /// Largest change of the duty in a tick (parameter 271).
    pub slew: u16,
    /// Shortest on-time (parameter 272).
    pub duty_min: u16,
    /// What dead time takes off a synchronously rectified duty.
    pub dead_time: u16,
    /// Above this bus voltage nothing may flow back: the over-voltage threshold less a margin.
    pub bus_guard: i32,
    /// First voltage in closed loop (parameter 84).
    pub initial_voltage: i32,
    /// Back-EMF per electrical rev/s (parameter 267); 0 unknown.
    pub back_emf: Gain,
}

/// What the state asks of the bridge.
#[derive(Clone, Copy, Debug)]
pub enum Demand {
    /// Bridge off.
    Off,
    /// A level: rotor lock, open loop, calibration.
    Voltage {
        /// Raw I16F16 volts.
        voltage: i32,
    },
    /// A speed: closed loop. Magnitudes in the direction of torque, raw I16F16 electrical rev/s.
    Speed {
        /// Estimated speed.
        measured: i32,
        /// Share of the voltage that is taken away, in 1/16: the rotor's position is getting uncertain.
        fade: u8,
    },
}

/// What a closed-loop mode has of its own. Speeds are raw I16F16 electrical rev/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ModeCoefficients {
    /// Speed loop, volts per electrical rev/s, per millisecond.
    pub speed: PiGains,
    /// Smallest set-point.
    pub speed_min: i32,
    /// Largest set-point.
    pub speed_max: i32,
    /// Largest duty, raw U1F15.
    pub duty_max: u16,
    /// The speed is known from crossings alone, once in a sector.
    pub sparse: bool,
}

/// What the commutation applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Duty from the next period.
    pub duty: Duty,
    /// Freewheeling from the next period.
    pub rectification: Rectification,
    /// What bounds the duty.
    pub limiter: Limiter,
}

/// State of the control station.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Control {
    speed: Pi,
    current: Pi,
    setpoint: Ramp,
    limit: CurrentLimit,
    /// Output and error of the speed loop, held between milliseconds.
    speed_voltage: i32,
    speed_error: i32,
    millisecond: u16,
    /// Share of a speed loop's turn that has been earned, electrical rev/s.
    turn: i32,
    phase_current: i32,
    coasting: Option<Coasting>,
    /// Milliseconds for which a rotor that turned at the start, or while the bridge was off, is caught; 0 once it is.
    catching: u16,
    /// The bridge was off in the midst of this episode.
    interrupted: bool,
    /// The speed loop decides, by switches, and the current limiter waits at its voltage: as long as nothing comes near a limit, a tick is no
    /// more than the division by the bus voltage.
    settled: bool,
    output: Output,
}

/// Where a motor began to coast.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Coasting {
    speed: i32,
    voltage: i32,
}

/// Mean bus current that may flow back: 20 mA, what the drive itself consumes (Table 1).
const RETURN: i32 = -(1 << 16) / 50;
/// Mean bus current beyond which diodes take over: -0.3 A.
const REGENERATING: i32 = -(1 << 16) * 3 / 10;
/// Mean bus current that is clearly forward: 50 mA.
const MOTORING: i32 = (1 << 16) / 20;

/// Longest catching of an idle motor: 20 ms, more than an electrical revolution at 3000 electrical rpm.
const CATCH: u16 = 20;

/// 500 rpm with 4 pole pairs (Table 2): from there on the speed loop runs every millisecond, raw electrical rev/s.
const WHOLE: i32 = 33 << 16;

/// A current limit may take the duty back this many times faster than it rises.
const RETREAT: u16 = 8;

impl Control {
    /// A driven episode begins from standstill, or from `speed` (raw electrical rev/s) of a rotor that turns already:
    /// that one is caught with diodes, where no voltage is too small.
    pub fn start(&mut self, c: &ControlCoefficients, speed: i32) {
        *self = Self { limit: self.limit, ..Self::default() };
        self.limit.start(&c.limits);
        self.setpoint.set(speed);
        self.take_over(c.initial_voltage);
        self.catching = if speed == 0 { 0 } else { CATCH };
        if self.catching == 0 {
            self.output.rectification = Rectification::Synchronous;
        }
    }

    /// Bumpless change from a level to the speed loop: every controller continues from `voltage` (what is [`applied`](Self::applied), or
    /// parameter 84), the set-point's ramp from the measured `speed` (raw electrical rev/s).
    pub fn hand_over(&mut self, speed: i32, voltage: i32) {
        self.setpoint.set(speed);
        self.speed_error = 0;
        (self.interrupted, self.catching, self.coasting) = (false, 0, None);
        self.take_over(voltage);
    }

    /// A tick begins. Its place in the millisecond, from 0: what needs no tick of its own is spread over these.
    #[inline]
    pub const fn tick(&mut self, c: &ControlCoefficients) -> u16 {
        self.millisecond += 1;
        if self.millisecond >= c.ticks_per_ms {
            self.millisecond = 0;
        }
        self.millisecond
    }

    /// Estimated mean phase current as of the last millisecond, raw I16F16 A.
    pub const fn phase_current(&self) -> i32 {
        self.phase_current
    }

    /// Voltage that the last duty gives on this bus, raw I16F16 V.
    pub const fn applied(&self, c: &ControlCoefficients, bus_voltage: i32) -> i32 {
        share(bus_voltage, self.output.duty.to_bits().saturating_sub(self.dead_time(c)))
    }

    /// Every controller continues from `voltage`.
    fn take_over(&mut self, voltage: i32) {
        self.settled = false;
        self.speed.wait(voltage);
        self.current.wait(voltage);
        self.speed_voltage = voltage;
    }

    /// Once a millisecond: the ratings. `turns`: the rotor is not known to stand.
    #[inline(never)]
    pub fn rate(
        &mut self,
        c: &ControlCoefficients,
        measurement: &Measurement,
        temperature: Celsius,
        turns: bool,
    ) {
        let (voltage, current) = (measurement.bus_voltage(), measurement.bus_current());
        self.phase_current = per_duty(current, self.output.duty.to_bits());
        self.limit.update(&c.limits, (voltage, current), self.phase_current, temperature, turns);
    }

    /// Once a millisecond in closed loop: the set-point's ramp, and the speed loop. Magnitudes in the direction of torque, raw I16F16 electrical
    /// rev/s; `target` is the set-point after saturation.
    #[inline(never)]
    pub fn turn(
        &mut self,
        c: &ControlCoefficients,
        mode: &ModeCoefficients,
        target: i32,
        speed: i32,
        (bus_voltage, bus_current): (i32, i32),
    ) {
        if self.interrupted {
            return;
        }
        if self.catching > 1 {
            self.catching -= 1;
        }
        if self.coasting.is_some() {
            self.speed_error = self.advance_setpoint(c, target, speed).saturating_sub(speed);
        } else if !mode.sparse || self.takes_turn(speed) {
            let ceiling = share(bus_voltage, mode.duty_max);
            self.speed_error = self.advance_setpoint(c, target, speed).saturating_sub(speed);
            let before = self.speed_voltage;
            self.speed_voltage = self.speed.step(&mode.speed, self.speed_error, 0, ceiling);
            self.settled = self.settled && self.may_follow(c, self.speed_voltage - before, bus_current);
            if self.settled {
                self.current.wait(self.speed_voltage);
            }
        }
    }

    /// Further down the current limiter waits there. Further up it does so if its proportional part would let that `rise` pass, which is at least what
    /// it would be at a duty of 1.
    fn may_follow(&self, c: &ControlCoefficients, rise: i32, bus_current: i32) -> bool {
        let room = self.limit.bound(self.output.duty.to_bits()).0.saturating_sub(bus_current);
        rise <= 0 || (room > 0 && c.current.proportional.apply(room) >= i64::from(rise))
    }

    /// One tick of a settled closed loop, in full: the next duty, if nothing comes near a limit. Else nothing is changed, and [`step`](Self::step) decides.
    #[inline]
    pub fn cruise(
        &mut self,
        c: &ControlCoefficients,
        duty_max: u16,
        measured: &Measured,
        measurement: &Measurement,
    ) -> Option<Duty> {
        let (bus, filtered) = (measured.bus_voltage.to_bits(), measured.bus_current_filtered.to_bits());
        let before = self.output.duty.to_bits();
        let draws = (filtered >= RETURN && bus <= c.bus_guard) || filtered >= MOTORING;
        if !self.settled || !draws || measured.bus_current.to_bits() > self.limit.bound(before).0 {
            return None;
        }
        let duty = measurement.duty(self.speed_voltage).to_bits().saturating_add(c.dead_time);
        let plain = duty >= c.duty_min && duty > c.dead_time && duty <= duty_max;
        if !plain || duty.abs_diff(before) >= c.slew {
            return None;
        }
        self.output.duty = Duty::from_bits(duty);
        Some(self.output.duty)
    }

    /// One tick.
    #[inline]
    pub fn step(
        &mut self,
        c: &ControlCoefficients,
        mode: &ModeCoefficients,
        demand: Demand,
        measured: &Measured,
        measurement: &Measurement,
    ) -> Output {
        let (wanted, own) = match demand {
            Demand::Off => {
                (self.output, self.interrupted, self.settled) = (Output::default(), true, false);
                return self.output;
            }
            Demand::Voltage { voltage } => (voltage, Limiter::Fixed),
            Demand::Speed { measured: speed, fade } => {
                let begins = self.speed_error < 0 && feeds(c, measured);
                let catches = self.catching > 0 || self.interrupted || self.coasting.is_some();
                if (begins || catches) && self.coasts(c, measured, measurement, speed) {
                    self.output = Output { limiter: Limiter::Return, ..Output::default() };
                    self.settled = false;
                    return self.output;
                }
                match fade {
                    0 => (self.speed_voltage, Limiter::Speed),
                    _ => (self.faded(c, speed, fade), Limiter::Fade),
                }
            }
        };
        let (voltage, limiter) = self.limit_current(c, wanted, own, measured);
        self.apply(c, measurement.duty(voltage), mode.duty_max, limiter, measured);
        // The slew limit passes within a tick or two and is no reason to forget; maximum duty is the loop's own ceiling.
        if limiter != own || own == Limiter::Fade {
            self.follow(c, mode, demand, measured);
        }
        self.settled = self.is_settled(c);
        self.output
    }

    /// What [`cruise`](Self::cruise) builds on.
    #[inline]
    fn is_settled(&self, c: &ControlCoefficients) -> bool {
        self.output.limiter == Limiter::Speed
            && self.output.rectification == Rectification::Synchronous
            && self.output.duty.to_bits() >= c.duty_min
            && self.current.waits_at(self.speed_voltage)
            && self.catching == 0
            && self.speed_voltage > 0
    }

    /// Something else than the speed loop decides: it goes along.
    #[inline(never)]
    fn follow(
        &mut self,
        c: &ControlCoefficients,
        mode: &ModeCoefficients,
        demand: Demand,
        measured: &Measured,
    ) {
        if let Demand::Speed { .. } = demand {
            let applied = self.applied(c, measured.bus_voltage.to_bits());
            self.speed.track(&mode.speed, applied, self.speed_error);
        }
    }

    /// A rotor that is caught, or that coasts: true while the bridge is to stay off.
    #[inline(never)]
    fn coasts(
        &mut self,
        c: &ControlCoefficients,
        measured: &Measured,
        measurement: &Measurement,
        speed: i32,
    ) -> bool {
        self.resume(c, measurement, speed);
        self.finish_catching(c, measured, measurement, speed);
        self.coast(c, measured, measurement, speed)
    }

    /// A motor that is faster than its set-point and would feed the bus coasts, bridge off, until it has fallen to it. Then
    /// the loops go on from the voltage they had, less what back-EMF has lost since: proportional to the speed.
    ///
    /// It looks at the filtered current, because at every commutation the winding's energy comes back in a pulse, and
    /// that is no braking. Freewheeling through diodes instead would not do: discontinuous current drives an
    /// unloaded motor beyond the speed that the same duty holds with switches.
    fn coast(
        &mut self,
        c: &ControlCoefficients,
        measured: &Measured,
        measurement: &Measurement,
        speed: i32,
    ) -> bool {
        match self.coasting {
            None if self.speed_error < 0 && feeds(c, measured) => {
                self.coasting = Some(Coasting { speed, voltage: self.speed_voltage });
            }
            Some(from) if self.speed_error >= 0 => {
                self.coasting = None;
                let left = i64::from(from.voltage) * i64::from(speed) / i64::from(from.speed.max(1));
                self.take_over(saturate64(left.min(from.voltage.into())));
                // No slew from 0: on the way up the switches would brake the motor.
                self.output.duty = measurement.duty(self.speed_voltage);
            }
            _ => {}
        }
        self.coasting.is_some()
    }

    /// After the bridge was off (sensors in doubt, a rotor that turned the other way) a rotor that still turns is caught at its
    /// back-EMF, and with diodes until its speed is certain again: a duty that rises from 0 under switches would short it, and the
    /// bus would get its energy.
    fn resume(&mut self, c: &ControlCoefficients, measurement: &Measurement, speed: i32) {
        if !core::mem::take(&mut self.interrupted) {
            return;
        }
        self.coasting = None;
        self.catching = if speed == 0 { 0 } else { CATCH };
        self.take_over(c.back_emf.apply32(speed.min(self.setpoint.value())));
        self.output.duty = measurement.duty(self.speed_voltage);
    }

    /// A rotor that turned already is caught with diodes, where no voltage is too small. Their light-load current is
    /// discontinuous and a voltage below back-EMF holds the speed, so before the switches take over, the controllers are
    /// put at back-EMF, or the motor would brake. An idle motor never draws the current that ends it: there time does, where
    /// back-EMF is known.
    fn finish_catching(
        &mut self,
        c: &ControlCoefficients,
        measured: &Measured,
        measurement: &Measurement,
        speed: i32,
    ) {
        if self.catching == 0 {
            return;
        }
        let late = self.catching == 1 && c.back_emf != Gain::ZERO;
        if late || measured.bus_current_filtered.to_bits() > MOTORING {
            self.catching = 0;
            let back_emf = c.back_emf.apply32(speed);
            if back_emf > self.speed_voltage {
                self.take_over(back_emf);
                self.output.duty = measurement.duty(back_emf);
            }
        }
    }

    /// What is above back-EMF fades, and with it the torque: a voltage below it would brake the motor into the bus. Where the constant is
    /// unknown all of the voltage fades.
    fn faded(&self, c: &ControlCoefficients, speed: i32, fade: u8) -> i32 {
        let back_emf = c.back_emf.apply32(speed).clamp(0, self.speed_voltage.max(0));
        back_emf + (self.speed_voltage - back_emf) / 16 * (16 - i32::from(fade.min(16)))
    }

    /// Set-point after its ramp, raw I16F16 electrical rev/s, a magnitude.
    pub const fn setpoint(&self) -> i32 {
        self.setpoint.value()
    }

    /// What the speed loop wants, raw I16F16 V.
    pub const fn speed_voltage(&self) -> i32 {
        self.speed_voltage
    }

    /// What was applied last.
    pub const fn output(&self) -> Output {
        self.output
    }

    /// Below the drive's range of speed crossings are so rare that the loop would integrate an old measurement over and over, until a
    /// light rotor stands: there it takes its turn less often, in proportion to the speed.
    const fn takes_turn(&mut self, speed: i32) -> bool {
        let share = if speed < WHOLE { speed } else { WHOLE };
        self.turn += if share > WHOLE / 8 { share } else { WHOLE / 8 };
        let due = self.turn >= WHOLE;
        if due {
            self.turn -= WHOLE;
        }
        due
    }

    /// The ramp waits while something else than the speed loop bounds a motor that lags behind: it must not run away
    /// from a speed that cannot follow.
    fn advance_setpoint(&mut self, c: &ControlCoefficients, target: i32, speed: i32) -> i32 {
        let setpoint = self.setpoint.value();
        let lagging = target > setpoint && speed < setpoint;
        if lagging && !matches!(self.output.limiter, Limiter::Speed | Limiter::Off) {
            return setpoint;
        }
        self.setpoint.step(target, c.speed_rate)
    }

    /// The wanted voltage, but no more than the current limiter allows. It looks at phase amperes, bus current over duty,
    /// so that its loop does not change with the duty.
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
        // The limiter's output is at least its integrator, or the ceiling, while there is room: most ticks need no division.
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

    /// What dead time takes off the duty in the present mode.
    const fn dead_time(&self, c: &ControlCoefficients) -> u16 {
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
        let lost = if duty.to_bits() > 0 { self.dead_time(c) } else { 0 };
        let wanted = shortest(c, duty.to_bits().saturating_add(lost));
        let (mut next, mut limiter) = (wanted, limiter);
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

    /// Diodes while a rotor is caught, while the bus is full and the motor hardly draws from it, and while it is fed in
    /// earnest: current in a diode cannot reverse. Else the switches.
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

/// The motor returns energy, or the bus is full and the motor hardly draws from it.
fn feeds(c: &ControlCoefficients, measured: &Measured) -> bool {
    let current = measured.bus_current_filtered.to_bits();
    current < RETURN || (measured.bus_voltage.to_bits() > c.bus_guard && current < MOTORING)
}

/// `voltage x duty`.
const fn share(voltage: i32, duty: u16) -> i32 {
    let voltage = if voltage > 0 { voltage } else { 0 };
    ((voltage as i64 * duty as i64) >> 15) as i32
}

/// `current / duty`, raw I16F16: what a mean bus current is in the phase. Below 1/32 the duty counts as that, so that
/// noise is not blown up. 32-bit division, which the processor has.
fn per_duty(current: i32, duty: u16) -> i32 {
    let duty = i32::from(duty.max(1 << 10));
    let current = current.clamp(-(1 << 19), 1 << 19);
    ((current << 11) / duty) << 4
}

/// A pulse shorter than the shortest one becomes the shortest or none, whichever is nearer.
fn shortest(c: &ControlCoefficients, duty: u16) -> u16 {
    match duty {
        long if long >= c.duty_min => long,
        short if short >= c.duty_min / 2 && short > 0 => c.duty_min,
        _ => 0,
    }
}
