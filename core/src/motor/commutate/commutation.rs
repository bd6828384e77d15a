//! Six-step commutation: which leg is switched, which is held low, which floats.
//!
//! Back-EMF against electrical angle, and the step that gives forward torque there:
//!
//! ```text
//!  angle      0    30    90    150   210   270   330   360
//!             |     |     |     |     |     |     |     |
//!  e_A        /‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾‾\                 /      + from  30 to 150
//!          __/                   \_____________/         - from 210 to 330
//!  e_B     _____              /‾‾‾‾‾‾‾‾‾‾‾‾‾‾\           + from 150 to 270
//!               \____________/                \____      - from -30 to 90
//!  e_C     ‾‾‾‾\                 /‾‾‾‾‾‾‾‾‾‾‾‾‾‾          + from 270 to  30
//!               \_______________/                        - from  90 to 210
//!
//!  sector      5 |  0  |  1  |  2  |  3  |  4  |  5
//!  Step       CB |  AB |  AC |  BC |  BA |  CA |  CB
//!  switched    C |  A  |  A  |  B  |  B  |  C  |  C
//!  low         B |  B  |  C  |  C  |  A  |  A  |  B
//!  floating    A |  C  |  B  |  A  |  C  |  B  |  A
//! ```
//!
//! Sector s spans 30 + 60 s to 90 + 60 s degrees. Forward torque takes the step of the rotor's sector,
//! reverse torque the opposite step (sector + 3). Step s pulls a resting rotor to 150 + 60 s degrees.

use crate::units::ElectricalAngle;
use serde::{Deserialize, Serialize};

/// A switch pattern: first letter switched (PWM), second held low, third phase floating.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[repr(u8)]
pub enum Step {
    /// All six switches off.
    #[default]
    Coast,
    /// A switched, B low.
    AB,
    /// A switched, C low.
    AC,
    /// B switched, C low.
    BC,
    /// B switched, A low.
    BA,
    /// C switched, A low.
    CA,
    /// C switched, B low.
    CB,
    /// Three-phase lock: A switched, B and C low. Pulls the rotor to 180 degrees.
    LockA,
    /// Three-phase lock: A and B switched, C low. Pulls to 240 degrees.
    LockAB,
    /// Three-phase lock: B switched, C and A low. Pulls to 300 degrees.
    LockB,
    /// Three-phase lock: B and C switched, A low. Pulls to 0 degrees.
    LockBC,
    /// Three-phase lock: C switched, A and B low. Pulls to 60 degrees.
    LockC,
    /// Three-phase lock: C and A switched, B low. Pulls to 120 degrees.
    LockCA,
}

/// State of one leg of the bridge in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leg {
    /// Both switches off.
    Floating,
    /// Low side on.
    Low,
    /// Switched with the duty.
    Switched,
}

/// The six running steps by sector.
pub const STEPS: [Step; 6] = [Step::AB, Step::AC, Step::BC, Step::BA, Step::CA, Step::CB];

/// The running steps round and round: no index of three bits is out of range, with or without half a turn.
const ROUND: [Step; 11] = {
    let mut steps = [Step::Coast; 11];
    let mut place = 0;
    while place < steps.len() {
        steps[place] = STEPS[place % 6];
        place += 1;
    }
    steps
};

/// The six locks by the angle they pull to, from 0 in steps of 60 degrees.
pub const LOCKS: [Step; 6] =
    [Step::LockBC, Step::LockC, Step::LockCA, Step::LockA, Step::LockAB, Step::LockB];

impl Step {
    /// Every pattern, in the order of their numbers.
    pub const ALL: [Self; 13] = [
        Self::Coast,
        Self::AB,
        Self::AC,
        Self::BC,
        Self::BA,
        Self::CA,
        Self::CB,
        Self::LockA,
        Self::LockAB,
        Self::LockB,
        Self::LockBC,
        Self::LockC,
        Self::LockCA,
    ];

    /// The pattern with this number.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// The legs A, B, C.
    pub const fn legs(self) -> [Leg; 3] {
        use Leg::{Floating, Low, Switched};
        match self {
            Self::Coast => [Floating, Floating, Floating],
            Self::AB => [Switched, Low, Floating],
            Self::AC => [Switched, Floating, Low],
            Self::BC => [Floating, Switched, Low],
            Self::BA => [Low, Switched, Floating],
            Self::CA => [Low, Floating, Switched],
            Self::CB => [Floating, Low, Switched],
            Self::LockA => [Switched, Low, Low],
            Self::LockAB => [Switched, Switched, Low],
            Self::LockB => [Low, Switched, Low],
            Self::LockBC => [Low, Switched, Switched],
            Self::LockC => [Low, Low, Switched],
            Self::LockCA => [Switched, Low, Switched],
        }
    }

    /// The step that gives torque in `direction` to a rotor in `sector` (0..=5).
    #[inline]
    pub const fn for_sector(sector: u8, direction: Direction) -> Self {
        let half_turn = match direction {
            Direction::Forward => 0,
            Direction::Reverse => 3,
        };
        ROUND[(sector & 7) as usize + half_turn]
    }

    /// The sector of a rotor that this step gives torque in `direction`.
    pub const fn rotor_sector(self, direction: Direction) -> Option<u8> {
        match (self.sector(), direction) {
            (Some(sector), Direction::Reverse) => Some((sector + 3) % 6),
            (sector, _) => sector,
        }
    }

    /// The phase that floats in a running step, 0 to 2.
    #[inline]
    pub const fn floating(self) -> Option<u8> {
        // By step: coast, AB to CB, the locks.
        const PHASES: [u8; 13] = [3, 2, 1, 0, 2, 1, 0, 3, 3, 3, 3, 3, 3];
        match PHASES[self as usize] {
            phase @ 0..=2 => Some(phase),
            _ => None,
        }
    }

    /// The angle that a three-phase lock pulls the rotor to, u32 turn.
    #[inline]
    pub const fn lock_angle(self) -> Option<u32> {
        // In the order of the steps: 180, 240, 300, 0, 60, 120 degrees.
        match (self as u8).checked_sub(Self::LockA as u8) {
            Some(place) => Some(((place as u32 + 3) % 6).wrapping_mul(u32::MAX / 6 + 1)),
            None => None,
        }
    }

    /// The sector that this step belongs to in forward direction.
    pub const fn sector(self) -> Option<u8> {
        match self {
            Self::AB => Some(0),
            Self::AC => Some(1),
            Self::BC => Some(2),
            Self::BA => Some(3),
            Self::CA => Some(4),
            Self::CB => Some(5),
            _ => None,
        }
    }
}

/// Which way the shaft is to turn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Direction {
    /// Electrical angle rises.
    #[default]
    Forward,
    /// Electrical angle falls.
    Reverse,
}

impl Direction {
    /// `value` in this direction: reversed, saturating, or as it is.
    #[inline]
    pub const fn signed(self, value: i32) -> i32 {
        match self {
            Self::Forward => value,
            Self::Reverse => value.saturating_neg(),
        }
    }

    /// +1 or -1.
    #[inline]
    pub const fn sign(self) -> i32 {
        match self {
            Self::Forward => 1,
            Self::Reverse => -1,
        }
    }
}

/// 60 degrees, rounded down: sectors by multiplication, not by this step.
pub const SECTOR: u16 = 10_923;

/// Sector 0..=5 of an electrical angle: sector s spans 30 + 60 s to 90 + 60 s degrees.
#[inline]
pub const fn sector_of(angle: ElectricalAngle) -> u8 {
    let from_first = angle.0.wrapping_sub(ElectricalAngle::from_degrees(30).0);
    ((from_first as u32 * 6) >> 16) as u8
}
