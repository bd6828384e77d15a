//! What the virtual scope can record.

use crate::dictionary::Decimal;

/// A signal of the scope. Its place in [`SCOPE_SIGNALS`] is its bit in parameter 22.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ScopeSignal {
    /// What it is called; a signal that is broadcast, too, has the name of Figure 14.
    pub name: &'static str,
    /// Unit of the value; "-" without one.
    pub unit: &'static str,
    /// Value of 1 per unit: value = sample * base / 4096, from -8 to almost 8 bases (Q3.12).
    pub base: Decimal,
}

/// Every signal in the order of its bit. Speeds are mechanical, and negative in reverse.
pub const SCOPE_SIGNALS: [ScopeSignal; 13] = [
    signal("Speed set-point", "rpm", 5000),
    signal("Mechanical estimated speed SL", "rpm", 5000),
    signal("Mechanical estimated speed HES", "rpm", 5000),
    signal("HV Voltage", "V", 10),
    signal("HV Current", "A", 2),
    signal("Electrical input Power", "W", 50),
    signal("VoltagePhaseA", "V", 10),
    signal("VoltagePhaseB", "V", 10),
    signal("VoltagePhaseC", "V", 10),
    signal("Duty", "%", 100),
    signal("Electrical angle", "deg", 360),
    signal("Drive state", "-", 1),
    signal("Active limiter", "-", 2),
];

const fn signal(name: &'static str, unit: &'static str, base: i64) -> ScopeSignal {
    ScopeSignal { name, unit, base: Decimal { digits: base, exponent: 0 } }
}
