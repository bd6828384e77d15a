//! Faults with a physical cause: what breaks, not which fault bit comes of it.

use super::phase::Phase;
use core::fmt;
use narx_core::shown::Shown;

/// Something that goes wrong while the plant runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Injection {
    /// Ambient temperature, degrees Celsius (fault bits 0 and 1).
    Ambient(f64),
    /// Open-circuit voltage of the supply, V (bits 2 and 3).
    Supply(f64),
    /// A resistor across the bus behind the current shunt, ohm (bit 4).
    Leak(f64),
    /// The gate driver of this leg fails: its switches stay off and the fault line is asserted (bit 5).
    Driver(Phase),
    /// The motor cable of this phase breaks (bit 5).
    OpenPhase(Phase),
    /// A hall line stays at this level (bit 6).
    HallStuck {
        /// The line.
        line: Phase,
        /// Its level.
        high: bool,
    },
    /// Two hall lines change places: A with B, B with C or C with A, named by the first (bit 6).
    HallSwapped(Phase),
    /// Short pulses on random hall lines, per second (bit 6).
    HallGlitches(f64),
    /// The hall sensors lose their supply: all lines pulled up (bit 6).
    HallSupplyLost,
    /// The shaft is held (bit 6 in hall mode, 27 or a restart without sensors).
    BlockedRotor,
    /// Output of the pressure bridge after its amplifier, V (bit 7).
    Pressure(f64),
    /// The hardware break input trips (bit 27).
    Break,
    /// DSIO1 is driven high from outside (bit 28 where configured so).
    Dsi1,
    /// DSIO2 is driven high from outside (bit 28 where configured so).
    Dsi2,
}

/// Options of a fault besides its name.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InjectionOptions {
    /// The number that some have.
    pub value: Option<f64>,
    /// Phase, leg or hall line of some.
    pub phase: Option<Phase>,
    /// Level of a hall line that is stuck.
    pub high: bool,
}

/// Reason why there is no such injection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InjectionError {
    /// There is no fault of this name.
    Unknown,
    /// It needs a value within this range, and has this one or none.
    Value {
        /// The value given.
        given: Option<f64>,
        /// Smallest.
        min: f64,
        /// Largest.
        max: f64,
        /// Their unit.
        unit: &'static str,
    },
    /// It needs a phase.
    Phase,
}

impl Injection {
    /// The names that [`Injection::named`] knows.
    pub const NAMES: [&str; 14] = [
        "ambient",
        "supply",
        "leak",
        "driver",
        "open-phase",
        "hall-stuck",
        "hall-swapped",
        "hall-glitches",
        "hall-supply-lost",
        "blocked-rotor",
        "pressure",
        "break",
        "dsi1",
        "dsi2",
    ];

    /// The injection of a name. To end one its value does not matter: any that is allowed will do.
    ///
    /// # Errors
    /// An unknown name, or an option that it needs and has not.
    pub fn named(name: &str, options: InjectionOptions) -> Result<Self, InjectionError> {
        let InjectionOptions { value: given, phase, high } = options;
        let value = |min: f64, max: f64, unit| {
            given.filter(|value| (min..=max).contains(value)).ok_or(InjectionError::Value {
                given,
                min,
                max,
                unit,
            })
        };
        let phase = phase.ok_or(InjectionError::Phase);
        Ok(match name {
            "ambient" => Self::Ambient(value(-55.0, 250.0, "degrees C")?),
            "supply" => Self::Supply(value(0.0, 80.0, "V")?),
            "leak" => Self::Leak(value(0.01, 1000.0, "ohm")?),
            "driver" => Self::Driver(phase?),
            "open-phase" => Self::OpenPhase(phase?),
            "hall-stuck" => Self::HallStuck { line: phase?, high },
            "hall-swapped" => Self::HallSwapped(phase?),
            "hall-glitches" => Self::HallGlitches(value(0.0, 10_000.0, "per second")?),
            "hall-supply-lost" => Self::HallSupplyLost,
            "blocked-rotor" => Self::BlockedRotor,
            "pressure" => Self::Pressure(value(-10.0, 10.0, "V")?),
            "break" => Self::Break,
            "dsi1" => Self::Dsi1,
            "dsi2" => Self::Dsi2,
            _ => return Err(InjectionError::Unknown),
        })
    }

    /// Index of its name in [`Injection::NAMES`].
    pub const fn index(&self) -> usize {
        match self {
            Self::Ambient(_) => 0,
            Self::Supply(_) => 1,
            Self::Leak(_) => 2,
            Self::Driver(_) => 3,
            Self::OpenPhase(_) => 4,
            Self::HallStuck { .. } => 5,
            Self::HallSwapped(_) => 6,
            Self::HallGlitches(_) => 7,
            Self::HallSupplyLost => 8,
            Self::BlockedRotor => 9,
            Self::Pressure(_) => 10,
            Self::Break => 11,
            Self::Dsi1 => 12,
            Self::Dsi2 => 13,
        }
    }

    /// A value that a fault of this name may have, to end it by; 0 for those without one.
    pub fn some_value(name: &str) -> f64 {
        match Self::named(name, InjectionOptions::default()) {
            Err(InjectionError::Value { min, .. }) => min,
            _ => 0.0,
        }
    }
}

impl fmt::Display for InjectionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => {
                f.write_str("unknown; one of ")?;
                Injection::NAMES.iter().enumerate().try_for_each(|(at, name)| {
                    f.write_str(if at == 0 { "" } else { ", " }).and_then(|()| f.write_str(name))
                })
            }
            Self::Value { given, min, max, unit } => {
                match given {
                    Some(value) => write!(f, "value {}", Shown::Plain(*value))?,
                    None => f.write_str("needs a value")?,
                }
                write!(f, ": must be a number from {} to {} {unit}", Shown::Plain(*min), Shown::Plain(*max))
            }
            Self::Phase => f.write_str("needs a phase, one of A, B, C"),
        }
    }
}

impl core::error::Error for InjectionError {}

/// The injections that are active.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Injected {
    pub(crate) ambient: Option<f64>,
    pub(crate) supply: Option<f64>,
    pub(crate) leak: Option<f64>,
    pub(crate) driver: [bool; 3],
    pub(crate) open: [bool; 3],
    pub(crate) hall_stuck: [Option<bool>; 3],
    pub(crate) hall_swapped: Option<Phase>,
    pub(crate) hall_glitches: Option<f64>,
    pub(crate) hall_supply_lost: bool,
    /// Not broken: the drive or its 5 V do not supply them.
    pub(crate) hall_supply_off: bool,
    pub(crate) blocked: bool,
    pub(crate) pressure: Option<f64>,
    pub(crate) emergency: bool,
    pub(crate) dsi1: bool,
    pub(crate) dsi2: bool,
}

impl Injected {
    /// Makes `injection` active or ends it; its value does not matter for ending it.
    pub(crate) fn set(&mut self, injection: Injection, active: bool) {
        let number = |value: f64| if active { Some(value) } else { None };
        match injection {
            Injection::Ambient(value) => self.ambient = number(value),
            Injection::Supply(value) => self.supply = number(value),
            Injection::Leak(value) => self.leak = number(value),
            Injection::Driver(leg) => self.driver[leg] = active,
            Injection::OpenPhase(phase) => self.open[phase] = active,
            Injection::HallStuck { line, high } => self.hall_stuck[line] = active.then_some(high),
            Injection::HallSwapped(line) => self.hall_swapped = active.then_some(line),
            Injection::HallGlitches(rate) => self.hall_glitches = number(rate),
            Injection::HallSupplyLost => self.hall_supply_lost = active,
            Injection::BlockedRotor => self.blocked = active,
            Injection::Pressure(value) => self.pressure = number(value),
            Injection::Break => self.emergency = active,
            Injection::Dsi1 => self.dsi1 = active,
            Injection::Dsi2 => self.dsi2 = active,
        }
    }
}
