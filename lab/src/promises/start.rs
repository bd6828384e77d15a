//! One sensorless start of a random plant, from the Drive request to its end.

use super::trial::Trial;
use narx_core::motor::{Board, State};
use narx_sim::random_plant::{RandomPlant, Spread};
use std::f64::consts::TAU;
use std::fmt;

/// Time for which closed loop must be held, s.
const HELD: f64 = 1.0;
/// Longest time of a start, s; one that has not ended by then is undecided.
const LONGEST: f64 = 15.0;
/// Largest relative difference of true and estimated speed at the end; if they differ more, the estimator
/// does not follow the rotor.
const AGREEMENT: f64 = 0.05;

/// End of a start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ending {
    /// State 4 was held for a second, and the rotor turned as estimated.
    Started {
        /// True if it needed no Auto-restart.
        first_try: bool,
    },
    /// The drive gave up and went to Standby.
    Standby,
    /// A fault with this extended code.
    Fault(u16),
    /// State 4 was held, but the rotor did not turn as estimated.
    Deceived,
    /// None of these within 15 s.
    Undecided,
}

impl fmt::Display for Ending {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Started { first_try: true } => write!(f, "started"),
            Self::Started { first_try: false } => write!(f, "started within Auto-restart"),
            Self::Standby => write!(f, "Standby"),
            Self::Fault(code) => write!(f, "fault {code:#06x}"),
            Self::Deceived => write!(f, "state 4 held, but the rotor does not turn as estimated"),
            Self::Undecided => write!(f, "no end within 15 s"),
        }
    }
}

/// A start and its end.
#[derive(Clone, Debug)]
pub struct Start {
    /// Seed that `--case` replays.
    pub case: u64,
    /// Plant that was started.
    pub drawn: RandomPlant,
    /// End of the start.
    pub ending: Ending,
    /// Time from the Drive request to the state 4 that was held, s; 0 if none was.
    pub to_closed_loop: f64,
    /// Largest magnitude of a phase current, A.
    pub peak_current: f64,
}

impl Start {
    /// Runs the start of that seed on this board; `None` if no plant follows from it.
    pub fn run(case: u64, board: &Board) -> Option<Self> {
        let drawn = RandomPlant::new(case, &Spread::PROMISED, board)?;
        let mut trial = Trial::new(&drawn.plant, &drawn.commissioning, "", false);
        Some(Self::follow(case, drawn, &mut trial))
    }

    /// Runs the start of a plant that has no seed.
    pub fn of(drawn: RandomPlant) -> Self {
        let mut trial = Trial::new(&drawn.plant, &drawn.commissioning, "", false);
        Self::follow(0, drawn, &mut trial)
    }

    /// Requests the start and follows it to its end.
    pub(crate) fn follow(case: u64, drawn: RandomPlant, trial: &mut Trial) -> Self {
        trial.start(drawn.rpm);
        let (mut first_try, mut driven, mut since) = (true, false, None);
        let mut ending = Ending::Undecided;
        let (mut from, mut estimates) = (*trial.seen(), Mean::default());
        for tick in 1..=(LONGEST / trial.tick_seconds).round() as u32 {
            trial.tick();
            let (now, state) = (f64::from(tick) * trial.tick_seconds, trial.state());
            driven |= state.is_driving();
            first_try &= state != State::SensorlessAutoRestart;
            match state {
                State::SensorlessClosedLoop => {
                    let held = now - *since.get_or_insert(now);
                    if held < HELD - 0.1 {
                        (from, estimates) = (*trial.seen(), Mean::default());
                    }
                    estimates.add(f64::from(trial.bench.status().speed_sensorless.to_bits()) / 65_536.0);
                    if held >= HELD {
                        ending = judge(trial, from.angle, from.time, estimates.value(), first_try);
                        break;
                    }
                }
                State::Standby if driven => {
                    ending = Ending::Standby;
                    break;
                }
                State::Fault => {
                    ending = Ending::Fault(trial.bench.status().extended_code);
                    break;
                }
                _ => since = None,
            }
        }
        let to_closed_loop =
            if matches!(ending, Ending::Started { .. }) { since.unwrap_or_default() } else { 0.0 };
        Self { case, drawn, ending, to_closed_loop, peak_current: trial.peak }
    }

    /// Returns whether it ended in a start, in Standby or in a fault with a name: the rotor never does
    /// anything else unnoticed.
    pub const fn is_accounted_for(&self) -> bool {
        !matches!(self.ending, Ending::Deceived | Ending::Undecided)
    }

    /// Returns whether the motor started.
    pub const fn started(&self) -> bool {
        matches!(self.ending, Ending::Started { .. })
    }

    /// Returns whether the motor started without Auto-restart.
    pub const fn started_at_once(&self) -> bool {
        matches!(self.ending, Ending::Started { first_try: true })
    }
}

/// Mean of the added values.
#[derive(Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: u32,
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    fn value(self) -> f64 {
        self.sum / f64::from(self.count.max(1))
    }
}

/// Compares the true speed of the last 0.1 s with the estimate, both as means: under a heavy load a single
/// crossing may be late.
fn judge(trial: &Trial, angle: f64, time: f64, estimated: f64, first_try: bool) -> Ending {
    let seen = trial.seen();
    let pole_pairs = f64::from(trial.bench.plant().config().motor.pole_pairs);
    let turning = (seen.angle - angle) / (seen.time - time) / TAU * pole_pairs;
    // The mean lags while the speed rises: over 0.1 s of the ramp, twice the tolerance is allowed.
    let apart = (estimated - turning).abs() > AGREEMENT * 2.0 * turning.abs();
    if apart { Ending::Deceived } else { Ending::Started { first_try } }
}

impl fmt::Display for Start {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let d = &self.drawn;
        let kind = if d.quadratic { "quadratic" } else { "Coulomb" };
        write!(
            f,
            "{}: {} at {:.1} V, {} rpm, inertia x{:.2}, friction x{:.2}, R x{:.2}, Ke x{:.2}, {kind} load {:.0} %, source {:.2} ohm, {:.0} deg",
            self.ending,
            d.preset.name,
            d.plant.supply.voltage,
            d.rpm,
            d.inertia,
            d.friction,
            d.resistance,
            d.back_emf,
            100.0 * d.load,
            d.plant.supply.resistance,
            d.plant.angle_deg,
        )
    }
}
