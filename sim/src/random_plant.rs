//! Random plants for start-up statistics: a motor of the market that differs from its data sheet, on a random
//! supply and load.
//!
//! Commissioning gets the data sheet; the plant gets what is drawn here. The same seed draws the same plant
//! everywhere.

use crate::plant::{LoadConfig, MotorConfig, PlantConfig};
use crate::presets::{PRESETS, Preset};
use crate::random::Random;
use core::f64::consts::TAU;
use narx_core::commissioning::{Commissioning, Mode, Nameplate};
use narx_core::dictionary::engineering;
use narx_core::dictionary::number;
use narx_core::motor::Board;

/// Ranges in which a plant's values are drawn. Factors are of the data sheet's value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Inertia, drawn evenly in its logarithm.
    pub inertia: (f64, f64),
    /// Coulomb friction.
    pub friction: (f64, f64),
    /// Resistance: 0.9 is a tolerance, 1.65 is copper at 190 degrees Celsius.
    pub resistance: (f64, f64),
    /// Torque and back-EMF constant: tolerance, and magnets that weaken when hot.
    pub back_emf: (f64, f64),
    /// Supply, V.
    pub supply: (f64, f64),
    /// Source resistance, ohm.
    pub source: (f64, f64),
    /// Load at the set-point's speed, share of the rated torque.
    pub load: (f64, f64),
    /// Friction and load together, share of the torque that the rotor lock has on this plant.
    pub breakaway_max: f64,
}

impl Spread {
    /// Ranges that a sensorless start promises to cope with.
    pub const PROMISED: Self = Self {
        inertia: (0.2, 5.0),
        friction: (0.0, 3.0),
        resistance: (0.9, 1.65),
        back_emf: (0.8, 1.05),
        supply: (18.0, 60.0),
        source: (0.0, 0.2),
        load: (0.0, 0.3),
        breakaway_max: 0.5,
    };
}

/// One plant, its commissioned drive and what is asked of it.
#[derive(Clone, Debug)]
pub struct RandomPlant {
    /// The motor that it was made from.
    pub preset: &'static Preset,
    /// Inertia, share of the data sheet's.
    pub inertia: f64,
    /// Coulomb friction, share of the data sheet's (mostly an estimate, see `presets`).
    pub friction: f64,
    /// Resistance, share of the data sheet's.
    pub resistance: f64,
    /// Torque and back-EMF constant, share of the data sheet's.
    pub back_emf: f64,
    /// Load at the set-point's speed, share of the rated torque.
    pub load: f64,
    /// The load grows with the square of the speed; otherwise it is Coulomb friction.
    pub quadratic: bool,
    /// Mechanical set-point, rpm, negative in reverse.
    pub rpm: i32,
    /// The plant itself.
    pub plant: PlantConfig,
    /// Result of commissioning from the data sheet and the supply.
    pub commissioning: Commissioning,
}

impl RandomPlant {
    /// The sensorless plant of `seed`, with this board. Combinations that commissioning refuses or that have
    /// more friction and load than promised are drawn again, which one of a hundred draws ends; should none
    /// do, there is no plant. Another board may allow another largest set-point, and accept another draw.
    pub fn new(seed: u64, spread: &Spread, board: &Board) -> Option<Self> {
        let mut random = Random::new(seed);
        (0..100).find_map(|_| Self::draw(&mut random, spread, board, seed))
    }

    fn draw(random: &mut Random, spread: &Spread, board: &Board, seed: u64) -> Option<Self> {
        let mut between = |(low, high): (f64, f64)| low + (high - low) * random.uniform();
        let preset = PRESETS.get(between((0.0, PRESETS.len() as f64)) as usize)?;
        let inertia = libm::exp(between((libm::log(spread.inertia.0), libm::log(spread.inertia.1))));
        let (friction, resistance) = (between(spread.friction), between(spread.resistance));
        let (back_emf, supply) = (between(spread.back_emf), between(spread.supply));
        let (source, load) = (between(spread.source), between(spread.load));
        let (share, angle) = (between((0.0, 1.0)), between((0.0, 360.0)));
        let quadratic = between((0.0, 1.0)) < 0.5;
        let reverse = between((0.0, 1.0)) < 0.5;

        let plate = Nameplate {
            motor: preset.motor.figures(),
            rated_current: preset.data.rated_current,
            supply,
            open_loop_speed: None,
        };
        let commissioning = plate.commission_on(board, Mode::Sensorless, None).ok()?;
        let range = commissioning.speed_max - commissioning.speed_min;
        let rpm = libm::ceil(commissioning.speed_min + share * range);
        let torque = load * preset.rated_torque();
        let speed = rpm * TAU / 60.0;
        let sheet = &preset.motor;
        let motor = MotorConfig {
            inertia: sheet.inertia * inertia,
            static_friction: sheet.static_friction * friction,
            resistance: sheet.resistance * resistance,
            torque_constant: sheet.torque_constant * back_emf,
            ..*sheet
        };
        let resting = motor.static_friction + if quadratic { 0.0 } else { torque };
        if resting > spread.breakaway_max * lock_torque(&commissioning, &motor, supply)? {
            return None;
        }
        let mut plant = PlantConfig { board: *board, ..PlantConfig::new(motor, supply) };
        plant.load = if quadratic {
            LoadConfig { quadratic: torque / (speed * speed), ..LoadConfig::default() }
        } else {
            LoadConfig { constant: torque, ..LoadConfig::default() }
        };
        plant.supply.resistance = source;
        plant.angle_deg = angle;
        plant.seed = seed;
        let rpm = if reverse { -(rpm as i32) } else { rpm as i32 };
        Some(Self {
            preset,
            inertia,
            friction,
            resistance,
            back_emf,
            load,
            quadratic,
            rpm,
            plant,
            commissioning,
        })
    }

    /// Winding temperature that this resistance would be of copper with the data sheet's value at 25 degrees
    /// Celsius.
    pub fn winding_temperature(&self) -> f64 {
        25.0 + (self.resistance - 1.0) / self.preset.motor.copper_drift
    }
}

/// Torque of the commissioned lock on the real motor at a supply of so many V, N m: its level over three
/// quarters of the line-to-line resistance, times the constant. Nothing if the set has no level.
pub fn lock_torque(commissioning: &Commissioning, motor: &MotorConfig, supply: f64) -> Option<f64> {
    let duty = engineering::value(&commissioning.parameters, number::LOCK_DUTY)? / 100.0;
    Some(motor.torque_constant * duty * supply / (0.75 * motor.resistance))
}
