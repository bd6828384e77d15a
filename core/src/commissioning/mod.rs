//! Commissioning: from a motor's data sheet and the supply to a full parameter set, by design rules.
//!
//! Everything here works from the figures of a data sheet, or from those that
//! [`identification`](crate::identification) has measured. R, L and k are line to line in the DC (six-step)
//! convention: `V = R I + k w`, `T = k I`.

use crate::dictionary::{Parameters, number};
use crate::motor::Board;
use core::fmt;
use heapless::Vec;
use libm::{exp, fmax, fmin, sqrt};

use crate::dictionary::engineering::{self, ValueError};
use crate::shown::Shown;

mod speed;
mod speed_loop;
mod torque;

use speed::Demand;
pub use speed::SpeedLimit;
pub use speed_loop::{SpeedLoop, TuningError};
pub use torque::{TorqueLimit, TorquePoint};

/// Which control mode to enable (Table 6).
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Mode {
    /// Hall closed loop.
    Hall,
    /// Sensorless closed loop, through open loop.
    Sensorless,
    /// Open loop only.
    OpenLoop,
}

impl Mode {
    /// Every mode.
    pub const ALL: [Self; 3] = [Self::Hall, Self::Sensorless, Self::OpenLoop];

    /// Returns the name that users know it by: `hall`, `sensorless`, `open-loop`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hall => "hall",
            Self::Sensorless => "sensorless",
            Self::OpenLoop => "open-loop",
        }
    }
}

/// The figures of a motor, at 25 degrees Celsius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motor {
    /// Pole pairs, 1 or more.
    pub pole_pairs: u8,
    /// Line to line, ohm, as data sheets print it; half of it is one phase's.
    pub resistance: f64,
    /// Line to line, H; half of it is one phase's.
    pub inductance: f64,
    /// Mean torque per DC ampere in ideal six-step, N m/A = V s/rad.
    pub torque_constant: f64,
    /// Of the rotor and what is coupled to it, kg m2.
    pub inertia: f64,
    /// Coulomb friction, N m.
    pub static_friction: f64,
    /// Viscous friction, N m s/rad.
    pub viscous_friction: f64,
}

/// Data of a motor that its user knows.
#[derive(Clone, Copy, Debug)]
pub struct Nameplate {
    /// The motor's data.
    pub motor: Motor,
    /// Rated DC current, A; without it [`rated_current`](Self::rated_current()) estimates one.
    pub rated_current: Option<f64>,
    /// Supply voltage, V.
    pub supply: f64,
    /// Mechanical speed of open loop, rpm; without it the slowest closed-loop speed.
    pub open_loop_speed: Option<f64>,
}

/// A parameter set and what the drive's limits made of the motor.
#[derive(Clone, Debug)]
pub struct Commissioning {
    /// Factory values with the motor's own written over them.
    pub parameters: Parameters,
    /// Limits of the drive that hold the motor back.
    pub notes: Vec<Note, 5>,
    /// Largest set-point, mechanical rpm.
    pub speed_max: f64,
    /// The limit that sets it.
    pub speed_limit: SpeedLimit,
    /// Smallest set-point, mechanical rpm.
    pub speed_min: f64,
    /// Mean phase current that the limits leave, A.
    pub phase_current: f64,
    /// Rated DC current of the motor, given or estimated, A.
    pub rated_current: f64,
    /// Continuous torque at the shaft from the smallest to the largest set-point, in equal steps of speed.
    pub torque: [TorquePoint; TORQUE_POINTS],
}

/// Number of speeds in [`Commissioning::torque`].
pub const TORQUE_POINTS: usize = 11;

/// A limit of the drive that holds the motor back.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Note {
    /// Current ripple leaves room for less than full duty below the 12 A peak (Table 1).
    DutyForRipple {
        /// Largest duty, 0 to 1.
        duty: f64,
        /// Ripple there, A peak to peak.
        ripple: f64,
    },
    /// Current ripple leaves less mean phase current below the 12 A peak.
    CurrentForRipple {
        /// Largest mean phase current, A.
        current: f64,
        /// Largest ripple, A peak to peak.
        ripple: f64,
    },
    /// At every commutation the winding returns its energy to the bus, and a source that takes nothing back
    /// leaves it to the 100 uF: more phase current would lift the bus to its over-voltage threshold.
    CurrentForBus {
        /// Largest mean phase current, A.
        current: f64,
    },
    /// Two control ticks no longer fit a sector above this speed.
    SpeedForTick {
        /// Mechanical rpm.
        speed: f64,
    },
    /// Sampled back-EMF needs four samples a sector; above this speed a sensorless motor needs comparators
    /// with capture.
    SpeedForSampling {
        /// Mechanical rpm.
        speed: f64,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (tenths, whole) = (|value| Shown::Rounded(value, 1), |value| Shown::Rounded(value, 0));
        match *self {
            Self::DutyForRipple { duty, ripple } => write!(
                f,
                "duty is limited to {} %: the current ripple there, {} A, allows no larger duty below the 12 A peak",
                tenths(duty * 100.0),
                tenths(ripple)
            ),
            Self::CurrentForRipple { current, ripple } => write!(
                f,
                "mean phase current is limited to {} A: the ripple of {} A must stay below the 12 A peak",
                tenths(current),
                tenths(ripple)
            ),
            Self::CurrentForBus { current } => write!(
                f,
                "mean phase current is limited to {} A: the energy that commutation returns must not lift the bus to 61 V",
                tenths(current)
            ),
            Self::SpeedForSampling { speed } => {
                write!(
                    f,
                    "sensorless speed is limited to {} rpm: above that, a sector has fewer than four samples of back-EMF",
                    whole(speed)
                )
            }
            Self::SpeedForTick { speed } => {
                write!(
                    f,
                    "speed is limited to {} rpm: above that, a sector has fewer than two control ticks",
                    whole(speed)
                )
            }
        }
    }
}

/// Reason why a motor cannot be commissioned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CommissioningError {
    /// The supply is outside the drive's 18 to 60 V (Table 2).
    Supply(f64),
    /// A figure of the motor is not a positive number.
    Motor {
        /// Which one.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// Even the smallest speed lies beyond what supply and limits allow.
    TooSlow {
        /// Speed that is left, mechanical rpm.
        speed_max: f64,
        /// Smallest speed that commutation needs, mechanical rpm.
        speed_min: f64,
        /// The limit that sets the largest speed.
        limit: SpeedLimit,
    },
    /// The largest speed that was asked for lies outside what the drive can do with this motor.
    SpeedMax {
        /// The speed that was asked for, mechanical rpm.
        value: f64,
        /// Smallest speed that commutation needs, mechanical rpm.
        least: f64,
        /// Largest speed that the drive allows without load, mechanical rpm.
        most: f64,
        /// The limit that sets `most`.
        limit: SpeedLimit,
    },
    /// A design rule asks for a value outside a parameter's range.
    Parameter(ValueError),
}

impl From<ValueError> for CommissioningError {
    fn from(error: ValueError) -> Self {
        Self::Parameter(error)
    }
}

impl fmt::Display for CommissioningError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Supply(voltage) => {
                write!(f, "supply voltage {} V is outside 18 to 60 V", Shown::Plain(*voltage))
            }
            Self::Motor { name, value } => {
                write!(f, "motor {name} {} must be greater than 0", Shown::Plain(*value))
            }
            Self::TooSlow { speed_max, speed_min, limit } => write!(
                f,
                "the drive's limits leave this motor {} rpm on this supply, less than the {} rpm it needs: {limit}",
                // Less than none is left where friction takes more than the supply can drive.
                Shown::Rounded(fmax(*speed_max, 0.0), 0),
                Shown::Rounded(*speed_min, 0)
            ),
            Self::SpeedMax { value, least, most, limit } => write!(
                f,
                "maximum speed {} rpm is outside {} to {} rpm: {limit}",
                Shown::Plain(*value),
                Shown::Rounded(*least, 0),
                Shown::Rounded(*most, 0)
            ),
            Self::Parameter(error) => write!(f, "no fitting value: {error}"),
        }
    }
}

impl core::error::Error for CommissioningError {}

/// Parameters that [`Nameplate::commission_on`] writes; the others keep their factory values.
pub const WRITTEN: [u16; 31] = [
    number::HALL_ENABLE,
    number::SENSORLESS_ENABLE,
    number::OPEN_LOOP_ENABLE,
    number::MOTOR_POLE_PAIRS,
    number::NOMINAL_SUPPLY,
    number::BACK_EMF_CONSTANT,
    number::WINDING_RESISTANCE,
    number::WINDING_INDUCTANCE,
    number::SPEED_MIN_HES,
    number::SPEED_MAX_HES,
    number::SPEED_MIN_SL,
    number::SPEED_MAX_SL,
    number::ZC_DISCARD,
    number::DUTY_MAX,
    number::DUTY_MAX_SL,
    number::PHASE_CURRENT_MAX,
    number::SPEED_RATE,
    number::HALL_INTERPOLATION_SPEED,
    number::SPEED_KP_SL,
    number::SPEED_KI_SL,
    number::SPEED_KP_HES,
    number::SPEED_KI_HES,
    number::HV_CURRENT_KP,
    number::HV_CURRENT_KI,
    number::HV_CURRENT_SOFT_START,
    number::LOCK_DUTY,
    number::OPEN_LOOP_DUTY,
    number::OPEN_LOOP_SPEED,
    number::LOCK_DURATION,
    number::OPEN_LOOP_RAMP,
    number::OPEN_LOOP_DURATION,
];

/// Supply range of Table 2, V.
pub const SUPPLY: core::ops::RangeInclusive<f64> = 18.0..=60.0;
/// Peak phase current (Table 1), A.
const RATED_PEAK: f64 = 12.0;
/// Peak phase current less what commutation adds to the ripple as a rule, which a bus shunt does not see, A.
const PEAK: f64 = RATED_PEAK - 0.6;
/// Commutation adds this share of the ripple where that is more. Where the ripple limits the duty, pulses are
/// short, and it does not.
const STEEP: f64 = 0.15;
/// And this much less without sensors, whose commutation is a few degrees off at times, A.
const SENSORLESS_PEAK: f64 = PEAK - 0.8;
/// Continuous phase current (Table 2), A.
const CONTINUOUS: f64 = 6.0;
/// Heat in the winding at the rated current, W, where no data sheet says it: half of the motors of `presets`
/// have 5 to 7 W, none has less than 4.8 W, three have more than 13 W.
const RATED_LOSS: f64 = 6.0;
/// Electrical revolutions a minute of 500 rpm with 4 pole pairs (Table 2).
const ELECTRICAL_RPM_MIN: f64 = 500.0 * 4.0;
/// [`ELECTRICAL_RPM_MIN`] as electrical revolutions a second.
const ELECTRICAL_MIN: f64 = ELECTRICAL_RPM_MIN / 60.0;
/// Largest speed that MEASUREMENT_1 and 5 carry, rpm.
const REPORTED_MAX: f64 = 32_767.0;
/// Largest duty where ripple allows it.
const DUTY_MAX: f64 = 0.95;
/// Share of the voltage at the largest duty that the largest speed may take; the rest is left to the speed
/// loop.
const VOLTAGE_SHARE: f64 = 0.95;
/// Bandwidth of the bus current limiter: 200 Hz, rad/s; its delay of 1.5 periods costs 11 degrees there.
const CURRENT_BANDWIDTH: f64 = 1257.0;
/// Bus capacitance (section "Features"), F.
const CAPACITANCE: f64 = 100e-6;
/// Over-voltage threshold of 61 V less a margin for its measurement, V.
const BUS_MAX: f64 = 60.9;
const TWO_PI: f64 = core::f64::consts::TAU;

impl Motor {
    /// Figures that no motor has at 0 or below.
    fn positive(&self) -> [(&'static str, f64); 5] {
        [
            ("resistance", self.resistance),
            ("inductance", self.inductance),
            ("torque constant", self.torque_constant),
            ("inertia", self.inertia),
            ("pole pairs", f64::from(self.pole_pairs)),
        ]
    }
}

fn not_positive(mut figures: impl Iterator<Item = (&'static str, f64)>) -> Option<(&'static str, f64)> {
    figures.find(|(_, value)| value.is_nan() || *value <= 0.0)
}

impl Nameplate {
    /// The parameter set for `mode`, as [`commission_on`](Self::commission_on) for narx's own board and
    /// without a largest speed.
    ///
    /// # Errors
    /// A supply or motor that the drive cannot run, with the value and what would be allowed.
    pub fn commission(&self, mode: Mode) -> Result<Commissioning, CommissioningError> {
        self.commission_on(&Board::BENCH, mode, None)
    }

    /// The parameter set for `mode`, with set-points up to `speed_max`, mechanical rpm.
    ///
    /// Without it, a motor whose rated current is given gets the speeds at which it still carries that
    /// current; any other motor the speeds that it reaches without load. [`Commissioning::torque`] says what
    /// load there is at each.
    ///
    /// # Errors
    /// A supply or motor that the drive cannot run, or a largest speed that it does not reach without load,
    /// with the value and what would be allowed.
    pub fn commission_on(
        &self,
        board: &Board,
        mode: Mode,
        speed_max: Option<f64>,
    ) -> Result<Commissioning, CommissioningError> {
        self.commission_within(board, mode, speed_max, f64::INFINITY)
    }

    /// As [`commission_on`](Self::commission_on), with no more phase current than `most`, A.
    pub(crate) fn commission_within(
        &self,
        board: &Board,
        mode: Mode,
        speed_max: Option<f64>,
        most: f64,
    ) -> Result<Commissioning, CommissioningError> {
        self.check()?;
        let mut notes = Vec::new();
        let mut design = Design::new(self, board, speed_max, most, &mut notes)?;
        if mode == Mode::Sensorless && !board.comparator_capture {
            design.leave_room_for_samples(board, self.motor.pole_pairs, &mut notes)?;
        }
        if let Some(value) = speed_max
            && design.speed_limit != SpeedLimit::Asked
        {
            let Design { speed_min: least, speed_max: most, speed_limit: limit, .. } = design;
            return Err(CommissioningError::SpeedMax { value, least, most, limit });
        }
        let mut parameters = Parameters::new();
        for (number, value) in [
            (number::HALL_ENABLE, f64::from(u8::from(mode == Mode::Hall))),
            (number::SENSORLESS_ENABLE, f64::from(u8::from(mode == Mode::Sensorless))),
            (number::OPEN_LOOP_ENABLE, f64::from(u8::from(mode == Mode::OpenLoop))),
        ] {
            write(&mut parameters, number, value)?;
        }
        self.write_motor(&mut parameters)?;
        self.write_limits(board, &design, &mut parameters)?;
        self.write_gains(&design, &mut parameters)?;
        self.write_start(mode, &design, &mut parameters)?;
        let torque = torque::points(self, &design, &parameters);
        Ok(Commissioning {
            parameters,
            notes,
            speed_max: design.speed_max,
            speed_limit: design.speed_limit,
            speed_min: design.speed_min,
            phase_current: design.phase_current,
            rated_current: self.rated_current(),
            torque,
        })
    }

    /// Rated DC current, A: the given one, or else an estimate. Rated is the current whose heat the winding
    /// can get rid of; where no data sheet says it, that heat is taken as 6 W (`R I^2`), and the current as
    /// no more than the drive's own 6 A.
    pub fn rated_current(&self) -> f64 {
        self.rated_current.unwrap_or_else(|| fmin(sqrt(RATED_LOSS / self.motor.resistance), CONTINUOUS))
    }

    fn check(&self) -> Result<(), CommissioningError> {
        if !SUPPLY.contains(&self.supply) {
            return Err(CommissioningError::Supply(self.supply));
        }
        let rated = [("rated current", self.rated_current())];
        match not_positive(self.motor.positive().into_iter().chain(rated)) {
            Some((name, value)) => Err(CommissioningError::Motor { name, value }),
            None => Ok(()),
        }
    }

    fn write_motor(&self, p: &mut Parameters) -> Result<(), CommissioningError> {
        let m = &self.motor;
        write(p, number::MOTOR_POLE_PAIRS, f64::from(m.pole_pairs))?;
        write(p, number::NOMINAL_SUPPLY, self.supply)?;
        write(p, number::BACK_EMF_CONSTANT, m.torque_constant * TWO_PI / 60.0)?;
        write(p, number::WINDING_RESISTANCE, m.resistance)?;
        write(p, number::WINDING_INDUCTANCE, m.inductance)
    }

    fn write_limits(&self, board: &Board, d: &Design, p: &mut Parameters) -> Result<(), CommissioningError> {
        for (low, high) in
            [(number::SPEED_MIN_HES, number::SPEED_MAX_HES), (number::SPEED_MIN_SL, number::SPEED_MAX_SL)]
        {
            write(p, low, d.speed_min)?;
            // A limit at its factory value, 4000 rpm, is one of 4 pole pairs: the drive scales it to the
            // motor's.
            let scaled = self.motor.pole_pairs != 4 && libm::round(d.speed_max) == 4000.0;
            let most = if scaled { 4001.0 } else { d.speed_max };
            write(p, high, most)?;
        }
        // Blanking: two ticks where eight of them fit a sector at full speed, less above; an eighth of the
        // sector stays blanked anyway.
        let sector = f64::from(board.tick_rate) * 10.0 / (d.speed_max * f64::from(self.motor.pole_pairs));
        write(p, number::ZC_DISCARD, fmin(2.0, libm::floor(sector / 8.0)))?;
        for duty in [number::DUTY_MAX, number::DUTY_MAX_SL] {
            write(p, duty, d.duty_max * 100.0)?;
        }
        write(p, number::PHASE_CURRENT_MAX, d.phase_current)?;
        write(p, number::SPEED_RATE, d.speed_rate)?;
        write(p, number::HALL_INTERPOLATION_SPEED, d.speed_min / 4.0)
    }

    /// Speed loop: its bandwidth is what the speed measurement allows at the slowest speed, with 70 degrees
    /// of phase margin. Current limiter.
    fn write_gains(&self, d: &Design, p: &mut Parameters) -> Result<(), CommissioningError> {
        let m = &self.motor;
        speed_loop::write_gains(p, m.speed_gains(0.7 * ELECTRICAL_MIN, m.resistance))?;
        // Current limiter: the winding is 1 / (R + L s), and pole-zero cancellation gives Kp = wc L, Ki = wc
        // R.
        write(p, number::HV_CURRENT_KP, CURRENT_BANDWIDTH * m.inductance)?;
        write(p, number::HV_CURRENT_KI, CURRENT_BANDWIDTH * m.resistance)?;
        write(p, number::HV_CURRENT_SOFT_START, fmin(3.0, d.phase_current))
    }

    /// Rotor lock and open loop: levels from resistance and current, times from inertia.
    fn write_start(&self, mode: Mode, d: &Design, p: &mut Parameters) -> Result<(), CommissioningError> {
        let m = &self.motor;
        // A lock leads through one phase and two in parallel: three quarters of the line-to-line resistance.
        let lock = 0.75 * m.resistance * d.start_current;
        let set = self.open_loop_speed.unwrap_or(d.speed_min);
        let speed = set * TWO_PI / 60.0;
        // With back-EMF in phase the open-loop level leaves the start current; without load the rotor runs
        // ahead until back-EMF stands across, and then u^2 = (R I)^2 + e^2 must not ask for more than the
        // phase may carry.
        let emf = m.torque_constant * speed;
        let across = m.resistance * 0.9 * d.phase_current;
        let level = fmin(m.resistance * d.start_current + emf, sqrt(across * across + emf * emf));
        let per_cent = |voltage: f64| fmin(100.0 * voltage / self.supply, d.duty_max * 100.0);
        write(p, number::LOCK_DUTY, per_cent(lock))?;
        write(p, number::OPEN_LOOP_DUTY, per_cent(level))?;
        write(p, number::OPEN_LOOP_SPEED, set)?;
        // A held rotor swings with wn = sqrt(p k I / J). Without sensors two locks of one period each bring
        // it near, and the kick, which is commutated on the crossings seen, follows it from there; a field
        // that turns by itself needs it at rest.
        let torque = m.torque_constant * d.start_current;
        let swing = TWO_PI / sqrt(f64::from(m.pole_pairs) * torque / m.inertia);
        let (lock, ramp, rest) = match mode {
            Mode::Sensorless => (fmax(0.08, 2.0 * swing), fmax(0.1, 1.75 * swing), 0.02),
            _ => (fmax(0.15, 5.0 * swing), fmax(0.2, 8.0 * swing), 0.1),
        };
        // A quarter of the torque accelerates.
        let ramp = fmax(4.0 * m.inertia * speed / torque, ramp);
        write(p, number::LOCK_DURATION, lock)?;
        write(p, number::OPEN_LOOP_RAMP, ramp)?;
        write(p, number::OPEN_LOOP_DURATION, ramp + rest)
    }
}

/// Figures that several rules share.
struct Design {
    duty_max: f64,
    /// Largest, A peak to peak.
    ripple: f64,
    phase_current: f64,
    start_current: f64,
    speed_min: f64,
    speed_max: f64,
    speed_limit: SpeedLimit,
    speed_rate: f64,
}

impl Design {
    fn new(
        plate: &Nameplate,
        board: &Board,
        asked: Option<f64>,
        most: f64,
        notes: &mut Vec<Note, 5>,
    ) -> Result<Self, CommissioningError> {
        let m = &plate.motor;
        let period = 1.0 / f64::from(board.tick_rate);
        // A quarter above the rated current, so that the limit does not bind at the rated load.
        let needed = fmin(1.25 * plate.rated_current(), CONTINUOUS);
        let demand = Demand::new(plate, needed, asked);
        // Ripple V D (1 - D) T / L, and the crest of a step plus half of it within the peak.
        let ripple = |duty: f64| plate.supply * duty * (1.0 - duty) * period / m.inductance;
        let duty_max = duty_within(2.0 * (PEAK - demand.crest) * m.inductance / (plate.supply * period));
        let widest = ripple(fmin(duty_max, 0.5));
        let steep = if duty_max < DUTY_MAX { 0.0 } else { STEEP * widest };
        let crest = fmin(PEAK, RATED_PEAK - steep) - widest / 2.0;
        let poles = f64::from(m.pole_pairs);
        let speed_min = ELECTRICAL_RPM_MIN / poles;
        let tick_speed = 0.9 * 60.0 / (12.0 * period * poles);
        let limits = [
            (demand.speed(plate, duty_max), SpeedLimit::of_duty(duty_max)),
            (tick_speed, SpeedLimit::Ticks),
            (REPORTED_MAX, SpeedLimit::Reported),
            (asked.filter(|speed| *speed > speed_min).unwrap_or(f64::INFINITY), SpeedLimit::Asked),
        ];
        let (speed_max, speed_limit) = least(&limits);
        // Steps are shortest at full speed.
        let step = 60.0 / (6.0 * poles * speed_max);
        let phase_current = crest * mean_of_crest(step * m.resistance / m.inductance);
        if duty_max < DUTY_MAX {
            push(notes, Note::DutyForRipple { duty: duty_max, ripple: widest });
        } else if crest < 0.8 * PEAK {
            push(notes, Note::CurrentForRipple { current: phase_current, ripple: widest });
        }
        // L I^2 / 2 <= C (V_max^2 - V^2) / 2. Three quarters of it: at high duty part of the energy
        // circulates in the bridge (measured on the bench).
        let room = CAPACITANCE * (BUS_MAX * BUS_MAX - plate.supply * plate.supply);
        let returned = sqrt(fmax(room, 0.0) / (0.75 * m.inductance));
        if returned < fmin(phase_current, needed) {
            push(notes, Note::CurrentForBus { current: returned });
        }
        let phase_current = fmin(fmin(phase_current, returned), most);
        if speed_limit == SpeedLimit::Ticks {
            push(notes, Note::SpeedForTick { speed: tick_speed });
        }
        if speed_max.is_nan() || speed_max <= speed_min {
            return Err(CommissioningError::TooSlow { speed_max, speed_min, limit: speed_limit });
        }
        let start_current =
            fmin(fmin(CONTINUOUS, phase_current), 0.8 * duty_max * plate.supply / m.resistance);
        // A third of the rated torque accelerates, and full speed takes 0.4 s at least.
        let acceleration = m.torque_constant * needed / m.inertia / 3.0 * 60.0 / TWO_PI;
        let speed_rate = fmin(fmin(acceleration, speed_max / 0.4), REPORTED_MAX);
        Ok(Self {
            duty_max,
            ripple: widest,
            phase_current,
            start_current,
            speed_min,
            speed_max,
            speed_limit,
            speed_rate,
        })
    }
}

impl Design {
    /// Four samples of back-EMF a sector, with 2 % for the speed loop to swing, and no more current than
    /// leaves its crest room.
    fn leave_room_for_samples(
        &mut self,
        board: &Board,
        pole_pairs: u8,
        notes: &mut Vec<Note, 5>,
    ) -> Result<(), CommissioningError> {
        self.phase_current = fmin(self.phase_current, SENSORLESS_PEAK - self.ripple / 2.0);
        let speed = 0.98 * f64::from(board.tick_rate) * 60.0 / (6.0 * 4.0 * f64::from(pole_pairs));
        if speed < self.speed_max {
            push(notes, Note::SpeedForSampling { speed });
            (self.speed_max, self.speed_limit) = (speed, SpeedLimit::Samples);
        }
        if self.speed_max <= self.speed_min {
            let Self { speed_max, speed_min, speed_limit: limit, .. } = *self;
            return Err(CommissioningError::TooSlow { speed_max, speed_min, limit });
        }
        Ok(())
    }
}

/// Mean phase current of a step over its crest, for steps of `length` winding time constants (L / R).
///
/// While a phase hands over to the next, its current falls by `(D V + 2 e) / 3 L` and that of the phase which
/// goes on by `(4 e - D V) / 3 L`; with `D V = 2 e` half as fast, so that commutation leaves half of the
/// crest. The step makes up for it, from 1/2 to 1 along `end - (end - 1/2) exp(-t)`: three quarters in the
/// mean if it is short, all of it if it is long.
fn mean_of_crest(length: f64) -> f64 {
    let left = exp(-length);
    let end = (1.0 - left / 2.0) / (1.0 - left);
    end - (end - 0.5) * (1.0 - left) / length
}

/// The largest duty up to [`DUTY_MAX`] for which no duty below has `D (1 - D)` above `product`.
fn duty_within(product: f64) -> f64 {
    if product >= 0.25 { DUTY_MAX } else { 0.5 - sqrt(0.25 - fmax(product, 0.0)) }
}

/// The least of some limits, with its name; one that is no number wins.
fn least<const N: usize, T: Copy>(limits: &[(f64, T); N]) -> (f64, T) {
    limits[1..].iter().fold(limits[0], |a, b| if b.0 < a.0 || b.0.is_nan() { *b } else { a })
}

fn push(notes: &mut Vec<Note, 5>, note: Note) {
    // Five kinds of note.
    let _ = notes.push(note);
}

/// Writes an engineering value, rounded to the parameter's resolution.
fn write(parameters: &mut Parameters, number: u16, value: f64) -> Result<(), CommissioningError> {
    Ok(engineering::set(parameters, number, value)?)
}
