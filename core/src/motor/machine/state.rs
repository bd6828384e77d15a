//! The eight states (section 7) and their transitions (Table 7) as one table.

use crate::blind;
use core::fmt;
use serde::{Deserialize, Serialize};

/// System states, numbered as the specification numbers them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[repr(u8)]
pub enum State {
    /// 0: boot and self-tests, PWM off.
    #[default]
    Initialization = 0,
    /// 1: PWM off.
    Standby = 1,
    /// 2: holds the rotor at a known position.
    RotorLock = 2,
    /// 3: rotates the field at a commanded speed.
    OpenLoop = 3,
    /// 4: commutates on back-EMF zero crossings.
    SensorlessClosedLoop = 4,
    /// 5: commutates on hall sensors.
    HallClosedLoop = 5,
    /// 6: PWM off until acknowledged.
    Fault = 6,
    /// 7: tries to catch or restart a sensorless motor that has stopped.
    SensorlessAutoRestart = 7,
}

impl State {
    /// Every state in order of its number.
    pub const ALL: [Self; 8] = [
        Self::Initialization,
        Self::Standby,
        Self::RotorLock,
        Self::OpenLoop,
        Self::SensorlessClosedLoop,
        Self::HallClosedLoop,
        Self::Fault,
        Self::SensorlessAutoRestart,
    ];

    /// The state's name in the specification (section 7).
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Initialization => "Initialization",
            Self::Standby => "Standby",
            Self::RotorLock => "Rotor lock",
            Self::OpenLoop => "Open-loop",
            Self::SensorlessClosedLoop => "Sensorless Closed-loop",
            Self::HallClosedLoop => "Closed-loop Hall Effect Sensors",
            Self::Fault => "Fault",
            Self::SensorlessAutoRestart => "Sensorless Auto-Restart",
        }
    }

    /// PWMs are on (states 2, 3, 4, 5, 7). The bridge is off in all others. `motor::drive` relies on that to
    /// observe the terminals, `node::parameters` to change the mode of the next start and, in Standby, to
    /// calibrate the current to 0, `node::storage` to write a flash that stops the processor, and `node::log`
    /// to erase the log.
    #[must_use]
    pub const fn is_driving(self) -> bool {
        !matches!(self, Self::Initialization | Self::Standby | Self::Fault)
    }
}

bitflags::bitflags! {
    /// Conditions on which the transitions depend.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
    pub struct Conditions: u16 {
        /// Boot time has elapsed and the self-tests passed.
        const BOOTED = 1 << 0;
        /// A critical fault is present.
        const CRITICAL = 1 << 1;
        /// A self-test or the parameter store failed at boot.
        const UNHEALTHY = 1 << 2;
        /// Standby is requested, or a shutdown whose fault bit is masked: the bridge goes off all the same.
        const STANDBY = 1 << 3;
        /// Drive or Reverse is requested by a fresh edge, and nothing refuses the start.
        const START = 1 << 4;
        /// Closed-loop hall enabled.
        const HALL = 1 << 5;
        /// Closed-loop sensorless enabled.
        const SENSORLESS = 1 << 6;
        /// Open loop enabled.
        const OPEN_LOOP = 1 << 7;
        /// A hall calibration is to be run by this start.
        const CALIBRATION = 1 << 8;
        /// The calibration has a result.
        const CALIBRATED = 1 << 9;
        /// No valid command for the time-out.
        const EXPIRED = 1 << 10;
        /// This state's duration has elapsed.
        const ELAPSED = 1 << 11;
        /// Estimated speed is 0.
        const STOPPED = 1 << 12;
        /// The other direction is requested.
        const REVERSAL = 1 << 13;
        /// Fault acknowledged: causes gone, wait elapsed, Standby requested since.
        const ACKNOWLEDGED = 1 << 14;
        /// The rotor's other source may go on: the terminals where the hall sensors fail, the hall sensors
        /// where the terminals do (parameter 308).
        const OTHER_SOURCE = 1 << 15;
    }
}

/// One row: in `from`, when all of `all` and none of `none` hold, go to `to`.
#[derive(Clone, Copy, Debug)]
pub struct Transition {
    /// State before.
    pub from: State,
    /// State after.
    pub to: State,
    /// All of these must hold.
    pub all: Conditions,
    /// None of these may hold.
    pub none: Conditions,
}

impl fmt::Display for Transition {
    /// Name in Table 7: the numbers of both states. A reversal shares it with the transition between the same
    /// states.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "T{}{}", self.from as u8, self.to as u8)
    }
}

const fn t(from: State, to: State, all: Conditions, none: Conditions) -> Transition {
    Transition { from, to, all, none }
}

const ANY: Conditions = Conditions::empty();
const REVERSED: Conditions = Conditions::REVERSAL.union(Conditions::STOPPED);
/// Neither a request to stand by nor one that nobody has renewed for the time-out starts anything.
const IDLE: Conditions = Conditions::STANDBY.union(Conditions::EXPIRED);

use Conditions as C;
use State::{
    Fault, HallClosedLoop, Initialization, OpenLoop, RotorLock, SensorlessAutoRestart, SensorlessClosedLoop,
    Standby,
};

/// Table 7, with T06, T16, T76, the reversals, and T54 and T45 between the closed loops (parameter 308). The
/// first row that holds wins, so the order is the priority: critical fault, Standby request, communication
/// time-out, reversal, time and speed.
pub const TRANSITIONS: [Transition; 36] = [
    t(Initialization, Fault, C::UNHEALTHY, ANY),
    t(Initialization, Standby, C::BOOTED, ANY),
    t(Standby, Fault, C::CRITICAL, ANY),
    t(Standby, RotorLock, C::START.union(C::CALIBRATION), IDLE),
    t(Standby, HallClosedLoop, C::START.union(C::HALL), IDLE),
    t(Standby, RotorLock, C::START.union(C::SENSORLESS), C::HALL.union(IDLE)),
    t(Standby, OpenLoop, C::START.union(C::OPEN_LOOP), C::HALL.union(C::SENSORLESS).union(IDLE)),
    t(RotorLock, Fault, C::CRITICAL, ANY),
    t(RotorLock, Standby, C::STANDBY, ANY),
    t(RotorLock, Fault, C::EXPIRED, ANY),
    t(RotorLock, Standby, C::REVERSAL, ANY),
    t(RotorLock, OpenLoop, C::ELAPSED, ANY),
    t(OpenLoop, Fault, C::CRITICAL, ANY),
    t(OpenLoop, Standby, C::STANDBY, ANY),
    t(OpenLoop, Fault, C::EXPIRED, ANY),
    t(OpenLoop, Standby, C::CALIBRATION.union(C::CALIBRATED), ANY),
    t(OpenLoop, Standby, REVERSED, ANY),
    t(
        OpenLoop,
        SensorlessClosedLoop,
        C::ELAPSED.union(C::SENSORLESS),
        C::HALL.union(C::CALIBRATION).union(C::REVERSAL),
    ),
    t(SensorlessClosedLoop, Fault, C::CRITICAL, ANY),
    t(SensorlessClosedLoop, Standby, C::STANDBY, ANY),
    t(SensorlessClosedLoop, Fault, C::EXPIRED, ANY),
    t(SensorlessClosedLoop, Standby, REVERSED, ANY),
    t(SensorlessClosedLoop, HallClosedLoop, C::STOPPED.union(C::OTHER_SOURCE), C::REVERSAL),
    t(SensorlessClosedLoop, SensorlessAutoRestart, C::STOPPED, C::REVERSAL),
    t(HallClosedLoop, Fault, C::CRITICAL, ANY),
    t(HallClosedLoop, Standby, C::STANDBY, ANY),
    t(HallClosedLoop, Fault, C::EXPIRED, ANY),
    t(HallClosedLoop, Standby, REVERSED, ANY),
    t(HallClosedLoop, SensorlessClosedLoop, C::OTHER_SOURCE, C::REVERSAL),
    t(Fault, Standby, C::ACKNOWLEDGED, C::CRITICAL),
    t(SensorlessAutoRestart, Fault, C::CRITICAL, ANY),
    t(SensorlessAutoRestart, Standby, C::STANDBY, ANY),
    t(SensorlessAutoRestart, Fault, C::EXPIRED, ANY),
    t(SensorlessAutoRestart, Standby, REVERSED, ANY),
    t(SensorlessAutoRestart, Standby, C::ELAPSED.union(C::STOPPED), ANY),
    t(SensorlessAutoRestart, SensorlessClosedLoop, C::ELAPSED, C::STOPPED),
];

/// Conditions that a start samples and that hold until the next one: they decide which row fires, never that
/// one does.
const MODES: Conditions = C::HALL.union(C::SENSORLESS).union(C::OPEN_LOOP).union(C::CALIBRATION);

/// By state: without one of these no row of it holds. A reversal waits for standstill, so in rows of both the
/// rarer counts.
const TRIGGERS: [Conditions; 8] = {
    let mut triggers = [ANY; 8];
    let mut index = 0;
    while index < TRANSITIONS.len() {
        let row = &TRANSITIONS[index];
        let all = row.all.difference(MODES);
        let needed = if all.contains(REVERSED) { C::REVERSAL } else { all };
        assert!(!needed.is_empty());
        triggers[row.from as usize] = triggers[row.from as usize].union(needed);
        index += 1;
    }
    triggers
};

/// The transition that fires, if any.
#[must_use]
#[inline]
pub fn transition(state: State, conditions: Conditions) -> Option<&'static Transition> {
    if conditions.intersects(TRIGGERS[state as usize]) { find(state, conditions) } else { None }
}

#[inline(never)]
fn find(state: State, conditions: Conditions) -> Option<&'static Transition> {
    let holds =
        |row: &Transition| conditions.contains(row.all) && !conditions.intersects(row.none) && !is_blind(row);
    TRANSITIONS.iter().find(|row| row.from == state && holds(row))
}

fn is_blind(row: &Transition) -> bool {
    blind::to("transition", row.from as u32 * 10 + row.to as u32)
}
