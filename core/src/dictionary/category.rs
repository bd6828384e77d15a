//! Parameter categories, as Tables 10 and 11 print them, and two of our own.

use super::parameter::Access;
use serde::{Deserialize, Serialize};

/// Category of a parameter. It decides in which states the parameter may be written ([`Category::access`]),
/// and whether a write has the coefficients of the tick built anew (`node::parameters`). Calibration is
/// stored by parameter 257 instead of 256, reset by 258, and left as it is by RESTORE_FACTORY_SETTING.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Category {
    /// 0-CommonInfo
    CommonInfo,
    /// 01-Identification
    Identification,
    /// 02-Calibration
    Calibration,
    /// 03-Machine characteristics
    Machine,
    /// 04-Control
    Control,
    /// 06-Command saturation
    CommandSaturation,
    /// 09-Limitation
    Limitation,
    /// 10-Timing
    Timing,
    /// 13-Instrumentation
    Instrumentation,
    /// 15-Logging data
    LoggingData,
    /// 16-Logging control
    LoggingControl,
    /// 20-Services (our own): commands.
    Services,
    /// 21-Diagnostics (our own): live values and counters.
    Diagnostics,
}

impl Category {
    /// Every category in the order of its printed number.
    pub const ALL: [Self; 13] = [
        Self::CommonInfo,
        Self::Identification,
        Self::Calibration,
        Self::Machine,
        Self::Control,
        Self::CommandSaturation,
        Self::Limitation,
        Self::Timing,
        Self::Instrumentation,
        Self::LoggingData,
        Self::LoggingControl,
        Self::Services,
        Self::Diagnostics,
    ];

    /// The printed label.
    pub const fn label(self) -> &'static str {
        match self {
            Self::CommonInfo => "0-CommonInfo",
            Self::Identification => "01-Identification",
            Self::Calibration => "02-Calibration",
            Self::Machine => "03-Machine characteristics",
            Self::Control => "04-Control",
            Self::CommandSaturation => "06-Command saturation",
            Self::Limitation => "09-Limitation",
            Self::Timing => "10-Timing",
            Self::Instrumentation => "13-Instrumentation",
            Self::LoggingData => "15-Logging data",
            Self::LoggingControl => "16-Logging control",
            Self::Services => "20-Services",
            Self::Diagnostics => "21-Diagnostics",
        }
    }

    /// Write access to the writable parameters of the category: those that identify, calibrate or protect the
    /// drive only while it does not drive; gains, saturations, scope and log at any time.
    pub const fn access(self) -> Access {
        match self {
            Self::Control
            | Self::CommandSaturation
            | Self::Instrumentation
            | Self::LoggingData
            | Self::LoggingControl => Access::Live,
            _ => Access::Stopped,
        }
    }
}
