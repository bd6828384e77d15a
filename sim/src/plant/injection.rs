//! Faults with a physical cause: what breaks, not which fault bit comes of it. The steps to a new one are in
//! docs/design/simulator.md, *A new injection*.

use super::phase::Phase;
use core::fmt;
use narx_core::shown::Shown;

/// Something that goes wrong while the plant runs. The bits in brackets are those of FAULT_WORD that the
/// drive sets.
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

/// Kind of an injection, and the options that it takes.
#[derive(Clone, Copy, Debug)]
pub struct InjectionKind {
    /// Name by which it is chosen.
    pub name: &'static str,
    /// Its value; none if it takes none.
    pub value: Option<InjectionValue>,
    /// Takes a phase, leg or hall line.
    pub phase: bool,
    /// Takes the level of a hall line.
    pub high: bool,
    make: fn(f64, Phase, bool) -> Injection,
}

/// Value that an injection takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InjectionValue {
    /// Its unit.
    pub unit: &'static str,
    /// Smallest.
    pub min: f64,
    /// Largest.
    pub max: f64,
    /// Value that a drive with factory parameters does not tolerate.
    pub example: f64,
}

impl InjectionKind {
    const fn new(name: &'static str, make: fn(f64, Phase, bool) -> Injection) -> Self {
        Self { name, value: None, phase: false, high: false, make }
    }

    const fn value(self, unit: &'static str, min: f64, max: f64, example: f64) -> Self {
        Self { value: Some(InjectionValue { unit, min, max, example }), ..self }
    }

    const fn phase(self) -> Self {
        Self { phase: true, ..self }
    }

    const fn high(self) -> Self {
        Self { high: true, ..self }
    }

    /// Returns the injection with these options; those that it does not take are ignored.
    ///
    /// # Errors
    /// An option that it takes is missing or out of range.
    pub fn with(&self, options: InjectionOptions) -> Result<Injection, InjectionError> {
        let InjectionOptions { value: given, phase, high } = options;
        let value = match self.value {
            None => 0.0,
            Some(InjectionValue { unit, min, max, .. }) => {
                let fits = given.filter(|value| (min..=max).contains(value));
                fits.ok_or(InjectionError::Value { given, min, max, unit })?
            }
        };
        let phase = if self.phase { phase.ok_or(InjectionError::Phase)? } else { Phase::A };
        Ok((self.make)(value, phase, high))
    }
}

impl Injection {
    /// All kinds, in the order of [`Injection::index`]. The worlds draw from them: a new one changes what
    /// happens in every world.
    pub const KINDS: [InjectionKind; 14] = [
        InjectionKind::new("ambient", |value, _, _| Self::Ambient(value)).value("°C", -55.0, 250.0, 195.0),
        InjectionKind::new("supply", |value, _, _| Self::Supply(value)).value("V", 0.0, 80.0, 63.0),
        InjectionKind::new("leak", |value, _, _| Self::Leak(value)).value("ohm", 0.01, 1000.0, 2.0),
        InjectionKind::new("driver", |_, leg, _| Self::Driver(leg)).phase(),
        InjectionKind::new("open-phase", |_, phase, _| Self::OpenPhase(phase)).phase(),
        InjectionKind::new("hall-stuck", |_, line, high| Self::HallStuck { line, high }).phase().high(),
        InjectionKind::new("hall-swapped", |_, line, _| Self::HallSwapped(line)).phase(),
        InjectionKind::new("hall-glitches", |value, _, _| Self::HallGlitches(value)).value(
            "per second",
            0.0,
            10_000.0,
            200.0,
        ),
        InjectionKind::new("hall-supply-lost", |_, _, _| Self::HallSupplyLost),
        InjectionKind::new("blocked-rotor", |_, _, _| Self::BlockedRotor),
        InjectionKind::new("pressure", |value, _, _| Self::Pressure(value)).value("V", -10.0, 10.0, 3.2),
        InjectionKind::new("break", |_, _, _| Self::Break),
        InjectionKind::new("dsi1", |_, _, _| Self::Dsi1),
        InjectionKind::new("dsi2", |_, _, _| Self::Dsi2),
    ];

    /// The names of all kinds.
    pub const NAMES: [&str; Self::KINDS.len()] = {
        let mut names = [""; Self::KINDS.len()];
        let mut at = 0;
        while at < names.len() {
            names[at] = Self::KINDS[at].name;
            at += 1;
        }
        names
    };

    /// The injection of a name. To end one its value does not matter: any that is allowed will do.
    ///
    /// # Errors
    /// An unknown name, or an option that it needs and has not.
    pub fn named(name: &str, options: InjectionOptions) -> Result<Self, InjectionError> {
        Self::kind(name).ok_or(InjectionError::Unknown)?.with(options)
    }

    fn kind(name: &str) -> Option<&'static InjectionKind> {
        const { &Self::KINDS }.iter().find(|kind| kind.name == name)
    }

    /// Index of its kind in [`Injection::KINDS`].
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
        Self::kind(name).and_then(|kind| kind.value).map_or(0.0, |value| value.min)
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
