//! The question that is put to a drive, and the figures that it answers with.

use crate::commissioning::Motor;
use crate::motor::Board;

/// Facts that the user knows of the motor, and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Pole pairs, 1 to 50. `None`: the rotor turns slowly, and somebody, or an encoder, marks its turns:
    /// [`mark`](super::Identification::mark).
    pub pole_pairs: Option<u8>,
    /// Largest phase current, A; without it the one whose heat in the winding is 6 W, 6 A at most.
    pub current: Option<f64>,
    /// Resistance of the bridge: two switches, ohm. It is taken off what is measured.
    pub bridge: f64,
    /// The motor may turn. If not, resistance and inductance alone are measured.
    pub turn: bool,
    /// The motor has hall sensors: they are calibrated, too. It must be allowed to turn then.
    pub halls: bool,
}

impl Asked {
    /// A motor with these pole pairs on the bridge of the simulated board; `None` if they are to be counted.
    pub fn new(pole_pairs: impl Into<Option<u8>>) -> Self {
        let bridge = f64::from(Board::BENCH.bridge_milliohm) / 1e3;
        Self { pole_pairs: pole_pairs.into(), current: None, bridge, turn: true, halls: false }
    }
}

/// A measured figure.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figure {
    /// The value.
    pub value: f64,
    /// The truth is within this of the value for about 95 of 100 motors.
    pub uncertainty: f64,
}

/// The measured figures, at the temperature of the motor at that time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Identified {
    /// Pole pairs, as given or as counted.
    pub pole_pairs: u8,
    /// Ambient temperature at the drive when the measurement began, degrees Celsius: that of a motor that has
    /// rested in the same room. `None` if the drive does not broadcast it.
    pub temperature: Option<f64>,
    /// Bus voltage without load, V.
    pub supply: f64,
    /// Largest phase current of the identification: the given one, or what the heat allows, A.
    pub current: f64,
    /// Line to line, ohm.
    pub resistance: Figure,
    /// Line to line, H.
    pub inductance: Figure,
    /// Figures of a rotor that has turned; `None` if it was held.
    pub turned: Option<Turned>,
    /// Wiring of the hall sensors, which the drive keeps; `None` if they were not asked for.
    pub halls: Option<Halls>,
}

/// Wiring of the hall sensors, in the terms of the drive's parameters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Halls {
    /// Order of the lines (parameter 262).
    pub order: u8,
    /// Lines that are inverted (parameter 263).
    pub polarity: u8,
    /// Offset of the edges, electrical degrees (parameter 80).
    pub offset: f64,
}

/// Figures that a rotor shows when it turns. If the second of the two accelerations fails, inertia and
/// friction are those of the first, with twice their uncertainty.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turned {
    /// Torque constant, N m/A, which is the back-EMF constant, V s/rad.
    pub torque_constant: Figure,
    /// Of the rotor and what is coupled to it, kg m2.
    pub inertia: Figure,
    /// Friction at `speed`, N m.
    pub friction: Figure,
    /// Coulomb friction, N m.
    pub static_friction: f64,
    /// Viscous friction, N m s/rad.
    pub viscous_friction: f64,
    /// Speed to which `friction` belongs, the largest that was used, rad/s.
    pub speed: f64,
}

impl Identified {
    /// The motor's figures for commissioning; `None` if it was not allowed to turn.
    pub fn motor(&self) -> Option<Motor> {
        let turned = self.turned?;
        Some(Motor {
            pole_pairs: self.pole_pairs,
            resistance: self.resistance.value,
            inductance: self.inductance.value,
            torque_constant: turned.torque_constant.value,
            inertia: turned.inertia.value,
            static_friction: turned.static_friction,
            viscous_friction: turned.viscous_friction,
        })
    }
}

/// Part of the identification that is under way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reads what the drive is.
    Asks,
    /// Holds the rotor: resistance and inductance.
    Holds,
    /// Turns the rotor slowly, in steps, and waits for [marks](super::Identification::mark): pole pairs.
    Counts,
    /// Turns the rotor and lets it coast: back-EMF constant.
    Spins,
    /// Accelerates it and lets it coast: inertia and friction.
    Accelerates,
    /// Turns the rotor one electrical revolution each way: hall sensors.
    Calibrates,
    /// Stops the motor and restores the parameters.
    Restores,
}

impl Stage {
    /// Its name: `asking`, `holding`, `counting`, `spinning`, `accelerating`, `calibrating`, `restoring`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Asks => "asking",
            Self::Holds => "holding",
            Self::Counts => "counting",
            Self::Spins => "spinning",
            Self::Accelerates => "accelerating",
            Self::Calibrates => "calibrating",
            Self::Restores => "restoring",
        }
    }
}
