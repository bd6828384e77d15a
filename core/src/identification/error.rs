//! Reasons why an identification has failed.

use super::Stage;
use crate::commissioning::CommissioningError;
use crate::dictionary::engineering::ValueError;
use crate::master::{DownloadError, JobError, NotTaken, Request, RequestError};
use crate::motor::State;
use crate::shown::Shown;
use core::fmt;

/// Reason why an identification has failed. The motor stands, and the drive has its former parameters, if it
/// still answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IdentificationError {
    /// Pole pairs outside 1 to 50.
    PolePairs(u8),
    /// A largest current outside 0 to 6 A.
    Current(f64),
    /// A resistance of the bridge outside 0 to 1 ohm.
    Bridge(f64),
    /// Hall sensors, or pole pairs that were not given, of a rotor that must not turn.
    Held,
    /// The marks tell no whole number of pole pairs, or one outside 1 to 50; 0 if three were not seen in
    /// three minutes.
    NotCounted {
        /// Electrical revolutions a turn.
        counted: f64,
    },
    /// A PWM rate that no board has, Hz.
    Rate(u32),
    /// A value that a parameter of the drive cannot have.
    Value(ValueError),
    /// The drive is not in Standby.
    NotInStandby(Option<State>),
    /// Nothing is received from the drive.
    Lost,
    /// The drive has no scope, or too small a memory for it.
    NoScope {
        /// Words of the memory.
        room: u16,
    },
    /// No current flows: no motor is connected, or one of its phases is open.
    NoMotor {
        /// Duty at which none flows, 0 to 1.
        duty: f64,
    },
    /// Two phases are shorted, or the bridge has less resistance than was said.
    Short {
        /// Resistance between them, bridge included, ohm.
        resistance: f64,
    },
    /// The supply cannot hold its voltage under load.
    Sags {
        /// Without, V.
        from: f64,
        /// With the strongest level, V.
        to: f64,
    },
    /// The records fit no motor: the rotor moved, or something else drives it.
    Unsteady(Stage),
    /// The rotor turned, or seemed to, and its terminals show no back-EMF.
    NoBackEmf {
        /// Speed that was asked for, rpm.
        rpm: f64,
    },
    /// The motor does not reach the speed.
    NotReached {
        /// Asked for, rpm.
        rpm: f64,
        /// Reached, rpm.
        reached: i16,
    },
    /// The supply leaves no room to accelerate.
    NoRoom {
        /// Slowest speed, rpm.
        slow: f64,
        /// Fastest speed, rpm.
        fast: f64,
    },
    /// The measured figures cannot be commissioned.
    Commissioning(CommissioningError),
    /// A start or a record has failed.
    Job(JobError),
    /// A request was not done.
    Request(Request, RequestError),
    /// A record was not downloaded.
    Download(DownloadError),
    /// The master takes no requests.
    NotTaken(NotTaken),
    /// Ended by [`abort`](super::Identification::abort).
    Aborted,
}

impl fmt::Display for IdentificationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plain = |value: f64| Shown::Plain(value);
        match *self {
            Self::PolePairs(value) => write!(f, "pole pairs {value} are outside 1 to 50"),
            Self::Current(value) => {
                write!(f, "largest current {} A must be above 0 and at most 6 A", plain(value))
            }
            Self::Bridge(value) => {
                write!(f, "resistance of the bridge {} ohm must be 0 or more and below 1 ohm", plain(value))
            }
            Self::Held => f.write_str("hall sensors and pole pairs need a rotor that may turn"),
            Self::NotCounted { counted } => {
                write!(f, "pole pairs {} by the marks: no whole number, 1 to 50", Shown::Rounded(counted, 2))
            }
            Self::Rate(rate) => write!(f, "a PWM rate of {rate} Hz is not one of this drive"),
            Self::Value(error) => error.fmt(f),
            Self::NotInStandby(Some(state)) => {
                write!(f, "the drive is in {}, not in Standby", state.name())
            }
            Self::NotInStandby(None) => f.write_str("the state of the drive is not known"),
            Self::Lost => f.write_str("nothing is received from the drive"),
            Self::NoScope { room } => {
                write!(f, "the scope's memory of {room} words is less than 1024")
            }
            Self::NoMotor { duty } => write!(
                f,
                "no current is seen at a duty of {} %: no motor is connected, a phase is open, or its resistance is too high",
                Shown::Rounded(100.0 * duty, 1)
            ),
            Self::Short { resistance } => {
                write!(f, "motor and bridge have {} ohm, no more than the bridge alone", plain(resistance))
            }
            Self::Sags { from, to } => write!(
                f,
                "the supply falls from {} to {} V under load",
                Shown::Rounded(from, 1),
                Shown::Rounded(to, 1)
            ),
            Self::Unsteady(stage) => write!(
                f,
                "what was recorded while {} fits no motor: something moves the shaft, or holds it",
                stage.name()
            ),
            Self::NoBackEmf { rpm } => write!(
                f,
                "the terminals show no back-EMF after {} rpm: does the rotor turn?",
                Shown::Rounded(rpm, 0)
            ),
            Self::NotReached { rpm, reached } => {
                write!(f, "the motor reaches {reached} rpm of {}", Shown::Rounded(rpm, 0))
            }
            Self::NoRoom { slow, fast } => write!(
                f,
                "the supply leaves no room between {} and {} rpm",
                Shown::Rounded(slow, 0),
                Shown::Rounded(fast, 0)
            ),
            Self::Commissioning(error) => write!(f, "what was measured cannot be commissioned: {error}"),
            Self::Job(error) => error.fmt(f),
            Self::Request(_, error) => error.fmt(f),
            Self::Download(error) => error.fmt(f),
            Self::NotTaken(error) => error.fmt(f),
            Self::Aborted => f.write_str("the identification was aborted"),
        }
    }
}

impl core::error::Error for IdentificationError {}
