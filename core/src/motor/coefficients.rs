//! Parameters built once into what the tick multiplies with. Rules between parameters are checked here.

use super::commutate::commutator::CommutatorCoefficients;
use super::control::limits::LimitCoefficients;
use super::control::pi::PiGains;
use super::control::{ControlCoefficients, ModeCoefficients};
use super::gain::Gain;
use super::guard::protection::{ProtectionCoefficients, Thresholds};
use super::guard::rails::RailCoefficients;
use super::machine::MachineCoefficients;
use super::machine::state::State;
use super::modes::{HALL, HALL_SENSORS, LEFT_OUT, OPEN_LOOP, OTHER_SOURCE, SENSORLESS};
use super::rotor::back_emf::BackEmfCoefficients;
use super::rotor::hall::HallWiring;
use super::rotor::hall::{HallCoefficients, sectors};
use super::rotor::hall_calibration::HallCalibrationCoefficients;
use super::rotor::open_loop::OpenLoopCoefficients;
use super::rotor::sensorless::SensorlessCoefficients;
use super::sense::front_end::Board;
use super::sense::measurement::{ChannelScale, MeasurementScales};
use super::sense::samples::Lines;
use crate::dictionary::{Decimal, Dictionary, Parameters, number};
use crate::units::{ElectricalAngle, quotient, ratio, saturate64};
use core::fmt;
use serde::{Deserialize, Serialize};

/// Everything configurable that the tick needs, in its own units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(C)]
pub struct Coefficients {
    /// Converter scales.
    pub measurement: MeasurementScales,
    /// Hall sensors.
    pub hall: HallCoefficients,
    /// Hall calibration.
    pub hall_calibration: HallCalibrationCoefficients,
    /// Open loop.
    pub open_loop: OpenLoopCoefficients,
    /// Back-EMF estimator and start sequence.
    pub sensorless: SensorlessCoefficients,
    /// Fault logic.
    pub protection: ProtectionCoefficients,
    /// State machine.
    pub machine: MachineCoefficients,
    /// Loops and limits.
    pub control: ControlCoefficients,
    /// Commutation.
    pub commutator: CommutatorCoefficients,
    /// Hall closed loop.
    pub hall_mode: ModeCoefficients,
    /// Sensorless closed loop.
    pub sensorless_mode: ModeCoefficients,
    /// Rev/s (raw I16F16) of 2^-32 turn a tick.
    pub speed_of_turns: Gain,
    /// Settling after the end of the on-time before an off-time sample, in 1/65 536 of a period.
    pub sample_settle: u16,
}

/// Reason why a parameter set does not build: the parameter at fault, its value and the range that the others
/// leave it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildError {
    /// Number of the parameter.
    pub parameter: u16,
    /// Its raw value.
    pub raw: i32,
    /// Smallest raw value that fits the other parameters.
    pub min: i64,
    /// Largest raw value that fits the other parameters.
    pub max: i64,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(row) = Dictionary::row(self.parameter) else { return f.write_str("unknown parameter") };
        let decimal = |digits| Decimal { digits, exponent: row.exponent };
        write!(
            f,
            "{row}: {} does not fit the other parameters, which allow {} to {}{}",
            row.engineering(self.raw),
            decimal(self.min),
            decimal(self.max),
            row.unit_suffix()
        )
    }
}

impl core::error::Error for BuildError {}

impl Coefficients {
    /// Coefficients of a state's loops: hall closed loop has its own, every other state uses those of motors
    /// without sensors (parameters 98 and 107, Table 11).
    #[inline]
    pub const fn mode(&self, state: State) -> &ModeCoefficients {
        if matches!(state, State::HallClosedLoop) { &self.hall_mode } else { &self.sensorless_mode }
    }

    /// Builds a parameter set for a board.
    ///
    /// # Errors
    /// The first parameter that does not fit the others.
    pub fn build(parameters: &Parameters, board: &Board) -> Result<Self, BuildError> {
        let mut b = Builder { parameters, board, misfit: None, binds: true };
        b.check();
        if let Some(misfit) = b.misfit {
            return Err(misfit);
        }
        let lock_level = b.level(number::LOCK_DUTY);
        let [open_loop, sensorless, hall] = b.enables();
        let coefficients = Self {
            measurement: b.measurement(),
            hall: b.part(HALL_SENSORS, true, Builder::hall),
            hall_calibration: HallCalibrationCoefficients::new(b.turns(), lock_level),
            // The fault logic uses its scale of speed, too.
            open_loop: b.only_if(open_loop || sensorless, |b| b.open_loop(lock_level)),
            sensorless: b.part(SENSORLESS, sensorless, |b| b.sensorless(lock_level)),
            protection: b.protection(),
            machine: b.machine(lock_level),
            control: b.control(),
            commutator: CommutatorCoefficients {
                earliest: board.earliest,
                advance: b.angle32(number::TIMING_ADVANCE),
            },
            hall_mode: b.part(HALL, hall, Builder::hall_mode),
            // Every state but the hall loop's uses its limits.
            sensorless_mode: b.only_if(sensorless, Builder::sensorless_mode),
            speed_of_turns: b.ratio(number::MOTOR_POLE_PAIRS, b.rate(), 65_536),
            sample_settle: quotient(b.rate() * 65_536 * 3, 1_000_000).min(u16::MAX as i64) as u16,
        };
        match b.misfit {
            Some(misfit) => Err(misfit),
            None => Ok(coefficients),
        }
    }
}

/// Speeds above this many electrical revolutions a second leave less than two ticks for a sector.
const TICKS_A_REVOLUTION_MIN: i64 = 12;
/// Time in which the level rises that finds the rotor of a motor without sensors, ms: that of parameter 109
/// within these. A faster one lets a light rotor leap ahead, a slower one loses time.
const KICK_MIN: i64 = 100;
const KICK_MAX: i64 = 200;
/// Silent terminals for this long mean a rotor at rest, ms.
const REST: i64 = 5;
/// 2 pi x 10^9.
const TWO_PI_E9: i64 = 6_283_185_307;
/// The bus may rise to this much below its over-voltage threshold before rectification turns to diodes.
const BUS_GUARD: i32 = (1 << 16) / 2;

/// PWM periods per second of the manual's drive, Hz: a tick of parameters 85, 86, 100 and 286 is one of its
/// periods, 100 us, whatever the board's rate.
const PERIOD_RATE: i64 = 10_000;

struct Builder<'a> {
    parameters: &'a Parameters,
    board: &'a Board,
    /// The first parameter that does not fit. What is built with it is dropped.
    misfit: Option<BuildError>,
    /// The part that is being built serves a mode that is enabled: a value that does not fit counts.
    binds: bool,
}

/// Converter codes that stand out of the noise: a signal of three channels, weighted 2, 1 and 1, with 0.7
/// codes of noise each has 1.7.
const NOISE: u16 = 4;

/// Often-used arithmetic stays out of line: 64 bits written out at every use would take half as much flash
/// again.
impl Builder<'_> {
    /// The raw value: none that is asked for here has more than 31 bits.
    #[inline(never)]
    fn raw(&self, number: u16) -> i32 {
        self.parameters.raw(number)
    }

    fn wide(&self, number: u16) -> i64 {
        self.raw(number).into()
    }

    fn is_set(&self, number: u16) -> bool {
        self.raw(number) == 1
    }

    fn rate(&self) -> i64 {
        (self.board.tick_rate as i64).max(1000)
    }

    #[inline(never)]
    fn pole_pairs(&self) -> i64 {
        self.raw(number::MOTOR_POLE_PAIRS).max(1).into()
    }

    #[inline(never)]
    fn note(&mut self, parameter: u16, min: i64, max: i64) {
        if self.binds {
            let raw = self.raw(parameter);
            self.misfit.get_or_insert(BuildError { parameter, raw, min, max });
        }
    }

    /// The modes that are enabled: open loop, sensorless and hall.
    fn enables(&self) -> [bool; 3] {
        [number::OPEN_LOOP_ENABLE, number::SENSORLESS_ENABLE, number::HALL_ENABLE]
            .map(|mode| self.is_set(mode))
    }

    /// Coefficients of a part that this build may leave out.
    fn part<T: Default>(&mut self, present: bool, enabled: bool, build: impl FnOnce(&mut Self) -> T) -> T {
        if present { self.only_if(enabled, build) } else { T::default() }
    }

    /// Rules, or coefficients, that bind only where a mode is enabled that needs them.
    fn only_if<T>(&mut self, enabled: bool, build: impl FnOnce(&mut Self) -> T) -> T {
        self.binds = enabled;
        let built = build(self);
        self.binds = true;
        built
    }

    /// The raw value of `number` has to lie within `min..=max`.
    #[inline(never)]
    fn within(&mut self, number: u16, min: i32, max: i32) {
        let value = self.raw(number);
        if value < min || value > max {
            self.note(number, min.into(), max.into());
        }
    }

    /// The gain `numerator / denominator`, for which the parameter may be too fine or too coarse.
    #[inline(never)]
    fn ratio(&mut self, number: u16, numerator: i64, denominator: i64) -> Gain {
        self.wide_ratio(number, numerator.into(), denominator.into())
    }

    /// The gain `factor / (10^decimals x divisor)` times the raw value.
    #[inline(never)]
    fn gain(&mut self, number: u16, factor: i64, decimals: u32, divisor: u32) -> Gain {
        let denominator = u128::from(10_u64.pow(decimals)) * u128::from(divisor);
        self.wide_ratio(number, (self.raw(number) as u64 * factor as u64).into(), denominator as i128)
    }

    #[inline(never)]
    fn wide_ratio(&mut self, number: u16, numerator: i128, denominator: i128) -> Gain {
        Gain::from_ratio(numerator, denominator).unwrap_or_else(|| {
            let (min, max) = Dictionary::row(number).map_or((0, 0), |row| (row.min(), row.max()));
            self.note(number, min, max);
            Gain::ZERO
        })
    }

    /// Raw I16F16 of a parameter in its unit, nearest. Powers of ten up to 10^16 leave no half.
    #[inline(never)]
    fn quantity(&self, number: u16) -> i32 {
        let exponent = Dictionary::row(number).map_or(0, |row| row.exponent);
        ratio(self.wide(number), 10_i32.pow(exponent.min(0).unsigned_abs().into()))
    }

    /// Raw U1F15 of a percentage in 0.01 %.
    #[inline(never)]
    fn duty(&self, number: u16) -> u16 {
        ((self.raw(number) << 15) / 10_000).clamp(0, 1 << 15) as u16
    }

    /// Ticks of a time in milliseconds, at least 1.
    #[inline(never)]
    fn ticks(&self, milliseconds: i64) -> u32 {
        quotient(milliseconds * self.rate(), 1000).clamp(1, u32::MAX as i64) as u32
    }

    /// Ticks of so many periods of the manual's drive, 100 us each, at least 1.
    #[inline(never)]
    fn periods(&self, periods: i64) -> u32 {
        quotient(periods * self.rate() + PERIOD_RATE / 2, PERIOD_RATE).max(1) as u32
    }

    /// 1/65 536 tick of so many periods of the manual's drive, 100 us each: the unit of parameters in ticks.
    #[inline(never)]
    fn periods_fine(&self, periods: i64) -> i64 {
        quotient((periods << 16) * self.rate(), PERIOD_RATE)
    }

    /// Ticks of a parameter in milliseconds, at least 1.
    #[inline(never)]
    fn duration(&self, number: u16) -> u32 {
        self.ticks(self.wide(number))
    }

    /// Raw I16F16 electrical rev/s of a parameter in mechanical rpm.
    #[inline(never)]
    fn speed(&self, number: u16) -> i32 {
        saturate64(quotient((i64::from(self.speed_limit(number)) << 16) * self.pole_pairs(), 60))
    }

    /// The level of a duty parameter, raw I16F16: volts of the nominal supply, or a share of the bus voltage
    /// where there is none.
    #[inline(never)]
    fn level(&self, number: u16) -> i32 {
        let whole = match self.quantity(number::NOMINAL_SUPPLY) {
            0 => 1 << 16,
            supply => supply,
        };
        saturate64(quotient(i64::from(whole) * self.wide(number), 10_000))
    }

    /// u32 turn of an angle in 0.01 degree.
    #[inline(never)]
    fn angle32(&self, number: u16) -> u32 {
        quotient(self.wide(number) << 32, 36_000) as u32
    }

    /// 2^-32 turn a tick of raw rev/s.
    fn turns(&mut self) -> Gain {
        self.ratio(number::MOTOR_POLE_PAIRS, 65_536, self.rate())
    }

    /// Volts per electrical rev/s.
    fn back_emf_gain(&mut self) -> Gain {
        self.gain(number::BACK_EMF_CONSTANT, 60, 6, self.pole_pairs() as u32)
    }

    /// Rules between parameters (PROTOCOL.md, section 5.4).
    fn check(&mut self) {
        let fastest = saturate64(quotient(self.rate() * 60, TICKS_A_REVOLUTION_MIN * self.pole_pairs()));
        let [open_loop, sensorless, hall] = self.enables();
        for switch in LEFT_OUT {
            self.within(*switch, 0, 0);
        }
        let half_period = quotient(500_000_000, self.rate());
        self.within(number::ON_TIME_MIN, 0, saturate64(half_period));
        self.within(number::HV_CURRENT_SOFT_START, 0, self.raw(number::HV_CURRENT_MAX));
        self.within(number::UNDER_VOLTAGE, 0, self.raw(number::OVER_VOLTAGE) - 1_500);
        self.within(number::TEMPERATURE_WARNING, i32::MIN, self.raw(number::OVER_TEMPERATURE) - 1);
        self.part(HALL, hall, |b| b.check_hall(fastest));
        self.part(SENSORLESS, sensorless, |b| b.check_sensorless(fastest));
        self.part(OPEN_LOOP, open_loop, |b| b.within(number::OPEN_LOOP_SPEED, 0, fastest));
        self.only_if(open_loop || sensorless, |b| {
            b.within(number::LOCK_DUTY, 0, b.raw(number::DUTY_MAX_SL));
            b.within(number::OPEN_LOOP_DUTY, 0, b.raw(number::DUTY_MAX_SL));
        });
    }

    fn check_hall(&mut self, fastest: i32) {
        let (low, high) = (number::SPEED_MIN_HES, number::SPEED_MAX_HES);
        self.within_speeds(high, 1, fastest);
        self.within_speeds(low, 0, self.speed_limit(high));
        // A rotor at the smallest set-point must pass a sector within the time-out, twice over; and 16 bits
        // hold the time-out.
        let slowest = i64::from(self.speed_limit(low).max(1)) * self.pole_pairs();
        let shortest = 2 * 60_000 / (6 * slowest).max(1);
        let longest = quotient(i64::from(u16::MAX) * 1000, self.rate());
        self.within(number::HALL_PERIOD_TIMEOUT, saturate64(shortest), saturate64(longest));
    }

    fn check_sensorless(&mut self, fastest: i32) {
        let (low, high) = (number::SPEED_MIN_SL, number::SPEED_MAX_SL);
        self.within_speeds(high, 1, fastest);
        self.within_speeds(low, 0, self.speed_limit(high));
        self.within(number::OPEN_LOOP_RAMP, 0, self.raw(number::OPEN_LOOP_DURATION));
        // 31 bits hold the time-out in 1/65 536 tick.
        let longest = quotient(PERIOD_RATE * i64::from(i16::MAX), self.rate());
        self.within(number::ZC_PERIOD_MAX, 0, saturate64(longest));
        // At the speed that open loop hands over at a sector must be over within the time-out, twice over.
        let time_out = self.pole_pairs() * self.wide(number::ZC_PERIOD_MAX);
        let slowest = saturate64(quotient(2 * 10 * PERIOD_RATE, time_out.max(1)));
        self.within(number::OPEN_LOOP_SPEED, slowest, self.speed_limit(high));
    }

    /// Set-points in force, mechanical rpm: parameters 101 to 104.
    fn speed_limit(&self, number: u16) -> i32 {
        self.parameters.speed_limit(number)
    }

    /// Notes the set-point limit in force if it is not [`within`](Self::within) this range.
    fn within_speeds(&mut self, number: u16, min: i32, max: i32) {
        let value = self.speed_limit(number);
        if value < min || value > max {
            self.note(number, min.into(), max.into());
        }
    }

    fn measurement(&self) -> MeasurementScales {
        let front = &self.board.front_end;
        MeasurementScales {
            bus_voltage: ChannelScale::new(front.bus_voltage, self.quantity(number::HV_VOLTAGE_OFFSET)),
            bus_current: ChannelScale::new(front.bus_current, self.quantity(number::HV_CURRENT_OFFSET)),
            phase_voltage: ChannelScale::new(front.phase_voltage, 0),
            filter: quotient(PERIOD_RATE << 16, self.rate()) as u32,
        }
    }

    fn hall(&mut self) -> HallCoefficients {
        let wiring = HallWiring {
            order: self.raw(number::HALL_ORDER) as u8,
            polarity: self.raw(number::HALL_POLARITY) as u8,
            offset: 0,
        };
        let standard = self.is_set(number::STANDARD_HALL_SEQUENCE);
        let offset = if standard { 0 } else { self.angle32(number::HALL_OFFSET_ANGLE) };
        let floor = self.turns().apply32(self.speed(number::HALL_INTERPOLATION_SPEED));
        HallCoefficients {
            sectors: sectors(wiring),
            offset: ElectricalAngle((offset >> 16) as u16),
            timeout: self.duration(number::HALL_PERIOD_TIMEOUT).min(u16::MAX as u32) << 16,
            interpolation_min: floor.unsigned_abs(),
            captured: self.board.hall_capture,
            lost_after: self.periods(3).min(u8::MAX.into()) as u8,
        }
    }

    fn open_loop(&mut self, lock_level: i32) -> OpenLoopCoefficients {
        let speed = self.speed(number::OPEN_LOOP_SPEED);
        let level = self.level(number::OPEN_LOOP_DUTY);
        // The lock level holds from standstill only where open loop has a higher one.
        let level_start = lock_level.min(level);
        let rise = level as i64 - level_start as i64;
        // At least 1 rev/s in the ramp's time: a set-point of 0 written live stops the field.
        let climb = speed.max(1 << 16);
        OpenLoopCoefficients {
            speed,
            rate: rise_a_ms(climb, self.wide(number::OPEN_LOOP_RAMP)),
            level_start,
            level,
            slope: self.ratio(number::OPEN_LOOP_DUTY, rise, (speed as i64).max(1)),
            turns: self.turns(),
        }
    }

    fn back_emf(&mut self) -> BackEmfCoefficients {
        let delay = |raw: i64| saturate64(self.periods_fine(raw) / 100);
        let delays = self.wide(number::ZC_DELAY);
        let phase = self.board.front_end.phase_voltage;
        BackEmfCoefficients {
            terminal: ChannelScale::new(phase, 0),
            noise: NOISE.into(),
            silence: phase.zero.saturating_add(NOISE),
            settle: self.periods(8).min(u16::MAX.into()) as u16,
            discard: self.periods_fine(self.wide(number::ZC_DISCARD)) as u32,
            earliest: self.board.earliest,
            comparator: self.board.comparator_capture,
            delay_rising: delay(delays),
            delay_falling: delay(delays + self.wide(number::ZC_DELAY_FALLING)),
            back_emf: self.back_emf_gain(),
            emf_of_turns: self.gain(
                number::BACK_EMF_CONSTANT,
                60 * self.rate(),
                6,
                65_536 * self.pole_pairs() as u32,
            ),
        }
    }

    fn rails(&mut self, back_emf: Gain) -> RailCoefficients {
        RailCoefficients {
            resistance: self.gain(number::WINDING_RESISTANCE, 1, 3, 1),
            commutation: self.gain(number::WINDING_INDUCTANCE, 3, 6, 1),
            back_emf,
            leak: 10_000,
        }
    }

    fn sensorless(&mut self, lock_level: i32) -> SensorlessCoefficients {
        let back_emf = self.back_emf();
        let (emf, ohm) = (number::BACK_EMF_CONSTANT, number::WINDING_RESISTANCE);
        let kick_level = self.level(number::OPEN_LOOP_DUTY);
        // Both locks together leave the rest before them and 2 ms of rotor lock's duration.
        let align = (self.wide(number::LOCK_DURATION) - REST - 2).max(20);
        // E = k f <= R I: the current of shorted windings, raw rev/s. It has no ripple, for which the mean
        // limit leaves room: a tenth more.
        let fall =
            quotient(self.wide(ohm) * self.wide(number::PHASE_CURRENT_MAX) * 11, 10) * self.pole_pairs();
        let brake = quotient(fall << 16, self.wide(emf) * 60);
        SensorlessCoefficients {
            back_emf,
            rails: self.rails(back_emf.back_emf),
            timeout: self.periods_fine(self.wide(number::ZC_PERIOD_MAX)) as u32,
            rest: self.ticks(REST),
            align: self.ticks(align),
            align_rate: rise_a_ms(lock_level, align / 4),
            align_level: lock_level,
            kick_rate: rise_a_ms(kick_level, self.wide(number::OPEN_LOOP_RAMP).clamp(KICK_MIN, KICK_MAX)),
            kick_level,
            kick_patience: self.ticks(50),
            kick_limit: self.duration(number::OPEN_LOOP_DURATION).max(self.ticks(1000)),
            brake_max: self.turns().apply32(saturate64(brake)),
        }
    }

    fn machine(&self, lock_level: i32) -> MachineCoefficients {
        let [open_loop, sensorless, hall] = self.enables();
        let lock = self.duration(number::LOCK_DURATION);
        MachineCoefficients {
            open_loop_enable: open_loop,
            sensorless_enable: sensorless,
            hall_enable: hall,
            boot: self.ticks(500),
            lock,
            lock_level,
            lock_rate: rise_a_ms(lock_level, self.wide(number::LOCK_DURATION) / 4),
            open_loop: self.duration(number::OPEN_LOOP_DURATION),
            auto_restart: self.ticks(2_000),
            fault_wait: self.duration(number::FAULT_WAIT),
            command_timeout: self.duration(number::CAN_TIMEOUT),
            other_source: OTHER_SOURCE && sensorless && hall && self.is_set(number::OTHER_SOURCE),
        }
    }

    fn protection(&self) -> ProtectionCoefficients {
        let thresholds = Thresholds {
            over_voltage: self.quantity(number::OVER_VOLTAGE),
            under_voltage: self.quantity(number::UNDER_VOLTAGE),
            over_current: self.quantity(number::OVER_CURRENT),
            over_temperature: self.quantity(number::OVER_TEMPERATURE),
            warning: self.quantity(number::TEMPERATURE_WARNING),
            over_pressure: self.quantity(number::OVER_PRESSURE),
            speed_max_hall: self.speed(number::SPEED_MAX_HES),
            speed_max_sensorless: self.speed(number::SPEED_MAX_SL),
            shutdown_lines: match self.raw(number::SHUTDOWN_INPUT) {
                1 => Lines::DSI1,
                2 => Lines::DSI2,
                _ => Lines::empty(),
            },
            critical_mask: self.parameters.raw_u32(number::CRITICAL_FAULT_MASK),
            hall_stall_ticks: self.duration(number::HALL_STALL_TIME),
        };
        ProtectionCoefficients::new(self.rate() as u32, &thresholds)
    }

    fn control(&mut self) -> ControlCoefficients {
        let rate = self.rate();
        // At most half of a period (`check`, and `Board::is_plausible`).
        let duty_of_ns = |ns: i64| quotient(ns * rate * 32_768, 1_000_000_000).clamp(0, 1 << 14) as u16;
        let (hot, warm) = (number::OVER_TEMPERATURE, number::TEMPERATURE_WARNING);
        let degrees = (self.quantity(hot) as i64 - self.quantity(warm) as i64).max(1);
        ControlCoefficients {
            ticks_per_ms: quotient(rate << 8, 1000).min(u16::MAX.into()) as u16,
            track: quotient(PERIOD_RATE << 13, rate) as u16,
            current: PiGains {
                proportional: self.gain(number::HV_CURRENT_KP, 1, 6, 1),
                integral: self.gain(number::HV_CURRENT_KI, 1, 3, rate as u32),
            },
            limits: LimitCoefficients {
                soft_start: self.quantity(number::HV_CURRENT_SOFT_START),
                maximum: self.quantity(number::HV_CURRENT_MAX).min(7 << 16),
                rate: quotient((self.quantity(number::HV_CURRENT_RATE) as i64) << 16, 1000),
                phase_current_max: self.quantity(number::PHASE_CURRENT_MAX),
                derating_start: self.quantity(warm),
                derating: self.ratio(hot, 65_536, degrees),
                bridge: quotient(i64::from(self.board.bridge_milliohm) << 16, 1000) as i32,
            },
            // No more than 10^7 rpm/s of 50 pole pairs: 2^29 and 32 bits.
            speed_rate: quotient((self.wide(number::SPEED_RATE) * self.pole_pairs()) << 32, 60_000),
            slew: quotient(i64::from(self.duty(number::DUTY_SLEW)) * 1000, rate).max(1) as u16,
            duty_min: duty_of_ns(self.wide(number::ON_TIME_MIN)),
            dead_time: duty_of_ns(self.board.dead_time_ns as i64),
            bus_guard: self.quantity(number::OVER_VOLTAGE) - BUS_GUARD,
            initial_level: self.level(number::INITIAL_DUTY),
            levels_of_bus: self.raw(number::NOMINAL_SUPPLY) == 0,
            back_emf: self.back_emf_gain(),
        }
    }

    fn hall_mode(&mut self) -> ModeCoefficients {
        // V/rpm x 10^-9 -> V per electrical rev/s: x 60 / pole pairs.
        let pole_pairs = self.pole_pairs() as u32;
        ModeCoefficients {
            speed: PiGains {
                proportional: self.gain(number::SPEED_KP_HES, 60, 9, pole_pairs),
                integral: self.gain(number::SPEED_KI_HES, 60, 12, pole_pairs),
            },
            speed_min: self.speed(number::SPEED_MIN_HES),
            speed_max: self.speed(number::SPEED_MAX_HES),
            duty_max: self.duty(number::DUTY_MAX),
            sparse: false,
        }
    }

    fn sensorless_mode(&mut self) -> ModeCoefficients {
        // V s/rad x 10^-6 -> V per electrical rev/s: x 2 pi / pole pairs.
        let pole_pairs = self.pole_pairs() as u32;
        ModeCoefficients {
            speed: PiGains {
                proportional: self.gain(number::SPEED_KP_SL, TWO_PI_E9, 15, pole_pairs),
                integral: self.gain(number::SPEED_KI_SL, TWO_PI_E9, 18, pole_pairs),
            },
            speed_min: self.speed(number::SPEED_MIN_SL),
            speed_max: self.speed(number::SPEED_MAX_SL),
            duty_max: self.duty(number::DUTY_MAX_SL),
            sparse: true,
        }
    }
}

/// Step a millisecond of a ramp that reaches a raw `level` in so many `milliseconds`, 16 extra bits.
#[inline(never)]
fn rise_a_ms(level: i32, milliseconds: i64) -> i64 {
    quotient((level as i64) << 16, milliseconds.max(1))
}
