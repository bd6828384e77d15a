//! Operation of a motor of the market at an operating point: the range that the drive's limits allow, and the
//! figures of a run.

use super::trial::Trial;
use narx_core::commissioning::{Commissioning, CommissioningError, Mode, Nameplate};
use narx_core::motor::control::limits::power_rating;
use narx_core::motor::machine::event::Limiter;
use narx_core::motor::{Board, State};
use narx_core::units::Volts;
use narx_sim::plant::{Ledger, LoadConfig, PlantConfig};
use narx_sim::presets::Preset;
use std::f64::consts::TAU;

/// Share of power and voltage that an operating point may use, so that the loops keep a control reserve.
const MARGIN: f64 = 0.9;
/// Share of the current limit that a mean current may have: within a step the current is a sawtooth, and the
/// limiter acts on its crest.
const CURRENT_MARGIN: f64 = 0.87;
/// Continuous phase current (Table 2): 6 A rms is 6 sqrt(3/2) A for two thirds of the time.
const CONTINUOUS: f64 = 7.35;

/// Time from the set-point to the measurement, s.
pub(crate) const SETTLE: f64 = 0.5;

/// An operating point.
#[derive(Clone, Copy, Debug)]
pub struct Point<'a> {
    /// Board of the drive.
    pub board: Board,
    /// The motor.
    pub preset: &'a Preset,
    /// Control mode, hall or sensorless.
    pub mode: Mode,
    /// Supply voltage, V.
    pub supply: f64,
    /// Share of the rated torque that the load takes at the set-point; it grows with the square of the speed.
    pub load: f64,
    /// Mechanical set-point, rpm; without it the middle of the range, or less where rating or supply require
    /// it.
    pub rpm: Option<f64>,
}

/// A point that the drive's limits allow.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) commissioning: Commissioning,
    pub(crate) rpm: i32,
    /// Load at the set-point, N m.
    pub(crate) torque: f64,
}

/// Figures of a run.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    /// Set-point, mechanical rpm.
    pub rpm: i32,
    /// Time from the Drive request to closed loop, s.
    pub to_closed_loop: f64,
    /// Time from the Drive request to a speed within 1 % of the set-point, s.
    pub to_speed: f64,
    /// Mean true speed over half a second less the set-point, share of it.
    pub error: f64,
    /// Standard deviation of the commutations' true positions, share of a commutation period of 60 degrees.
    pub jitter: f64,
    /// Mean position of the commutations, electrical degrees late.
    pub angle_mean: f64,
    /// Position furthest from ideal, electrical degrees.
    pub angle_worst: f64,
    /// Largest magnitude of a phase current from power-up on, A.
    pub peak_current: f64,
    /// Efficiency of the bridge: its output energy over the supply's, over the measured half second; 0
    /// without load.
    pub stage_efficiency: f64,
    /// Efficiency from supply to shaft, motor included.
    pub drive_efficiency: f64,
    /// True if, at the end, the speed loop alone bounds the duty.
    pub unlimited: bool,
}

impl Point<'_> {
    /// Runs the point: start, acceleration, half a second to settle, half a second of measurement.
    ///
    /// # Errors
    /// Fails with the limit that forbids the point, or with the event that did not happen.
    pub fn run(&self) -> Result<Figures, String> {
        self.run_after(SETTLE)
    }

    /// Runs the point as [`run`](Self::run) does, with `settle` seconds to settle.
    pub(crate) fn run_after(&self, settle: f64) -> Result<Figures, String> {
        let plan = self.plan()?;
        let speed = f64::from(plan.rpm) * TAU / 60.0;
        let mut plant = self.plant();
        plant.load = LoadConfig { quadratic: plan.torque / (speed * speed), ..LoadConfig::default() };
        plant.angle_deg = 77.0;
        let mut trial = Trial::new(&plant, &plan.commissioning, "", false);
        measure(&mut trial, plan.rpm, self.running(), settle)
    }

    /// State of the closed loop of this mode.
    pub(crate) fn running(&self) -> State {
        if self.mode == Mode::Hall { State::HallClosedLoop } else { State::SensorlessClosedLoop }
    }

    /// The fastest set-point that the limits allow with this load, rpm.
    pub(crate) fn speed_max(&self) -> Option<f64> {
        let most = self.speed_for(self.load * self.preset.rated_torque());
        Some(most.min(self.commission().ok()?.speed_max))
    }

    /// The motor on its supply, without load.
    pub(crate) fn plant(&self) -> PlantConfig {
        PlantConfig { board: self.board, ..PlantConfig::new(self.preset.motor, self.supply) }
    }

    /// Commissions the motor for its mode.
    ///
    /// # Errors
    /// The drive's limits do not allow this motor.
    pub fn commission(&self) -> Result<Commissioning, CommissioningError> {
        self.plate().commission_on(&self.board, self.mode, None)
    }

    fn plate(&self) -> Nameplate {
        let Preset { motor, data, .. } = self.preset;
        Nameplate {
            motor: motor.figures(),
            rated_current: data.rated_current,
            supply: self.supply,
            open_loop_speed: None,
        }
    }

    pub(crate) fn plan(&self) -> Result<Plan, String> {
        let commissioning = self.commission().map_err(|error| error.to_string())?;
        let torque = self.load * self.preset.rated_torque();
        let needed = self.current(torque);
        let current = commissioning.phase_current.min(CONTINUOUS);
        if needed > CURRENT_MARGIN * current {
            let why = commissioning.notes.first().map_or(String::new(), |note| format!(": {note}"));
            return Err(format!("{torque:.3} N m take {needed:.1} A, the limits leave {current:.1} A{why}"));
        }
        let middle = 0.5 * (commissioning.speed_min + commissioning.speed_max);
        let most = self.speed_for(torque).min(commissioning.speed_max);
        let rpm = self.rpm.unwrap_or(middle.min(most)).ceil();
        if !(commissioning.speed_min..=most.ceil()).contains(&rpm) {
            return Err(format!(
                "{rpm:.0} rpm is outside {:.0} to {most:.0} rpm, where the limits leave {torque:.3} N m",
                commissioning.speed_min
            ));
        }
        Ok(Plan { commissioning, rpm: rpm as i32, torque })
    }

    /// Current that `torque` and Coulomb friction take, A.
    fn current(&self, torque: f64) -> f64 {
        (torque + self.preset.motor.static_friction) / self.preset.motor.torque_constant
    }

    /// Highest speed at which the rating and the supply leave `torque`, rpm: `P = T w + R I^2` and `U = R I +
    /// 3 L I f + k w`, which includes the voltage that turns the current over six times a revolution.
    fn speed_for(&self, torque: f64) -> f64 {
        let motor = &self.preset.motor;
        let current = self.current(torque);
        let loss = motor.resistance * current * current;
        let by_power = (MARGIN * self.power_max() - loss) / (torque + motor.static_friction);
        let turning = 3.0 * motor.inductance * current * f64::from(motor.pole_pairs) / TAU;
        let by_voltage =
            (MARGIN * self.supply - motor.resistance * current) / (motor.torque_constant + turning);
        by_power.min(by_voltage) * 60.0 / TAU
    }

    /// Power limit: power rating and 7 A of input current (Table 2), W.
    fn power_max(&self) -> f64 {
        let rating = power_rating(Volts::from_milli((self.supply * 1e3) as i32));
        f64::from(rating).min(7.0 * self.supply)
    }
}

/// Measures the figures of a start to `rpm`.
pub(crate) fn measure(trial: &mut Trial, rpm: i32, closed: State, settle: f64) -> Result<Figures, String> {
    let target = f64::from(rpm);
    trial.start(rpm);
    let to_closed_loop = trial.until(8.0, |trial| trial.state() == closed).ok_or("no closed loop in 8 s")?;
    let reached = |trial: &Trial| (trial.seen().speed * 60.0 / TAU / target - 1.0).abs() < 0.01;
    let more = trial.until(8.0, reached).ok_or("set-point not reached in 8 s")?;
    trial.run_while(settle, |_| true);
    let from = *trial.seen();
    let commutations = trial.commutations(0.5);
    let (mean, jitter) = commutations.mean_and_jitter();
    let errors = commutations.errors().iter().copied();
    let worst = errors.fold(0.0, |worst: f64, e| if e.abs() > worst.abs() { e } else { worst });
    let seen = trial.seen();
    let mean_rpm = (seen.angle - from.angle) / (seen.time - from.time) * 60.0 / TAU;
    if trial.state() != closed {
        return Err(format!("left closed loop: {}", trial.state().name()));
    }
    let energy = |of: fn(&Ledger) -> f64| of(&seen.ledger) - of(&from.ledger);
    let input = energy(|ledger| ledger.source - ledger.source_loss);
    let lost = energy(|ledger| ledger.switches + ledger.diodes);
    let share = |part: f64| if input > 0.0 { part / input } else { 0.0 };
    Ok(Figures {
        rpm,
        stage_efficiency: share(input - lost),
        drive_efficiency: share(energy(|ledger| ledger.load)),
        to_closed_loop,
        to_speed: to_closed_loop + more,
        error: mean_rpm / target - 1.0,
        jitter,
        angle_mean: mean,
        angle_worst: worst,
        peak_current: trial.peak,
        unlimited: trial.bench.status().limiter == Limiter::Speed,
    })
}
