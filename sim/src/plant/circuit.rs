//! What the three legs do, and the circuit that comes of it until the next one changes.

use super::wiring::{Wiring, dot};

/// What a leg of the bridge does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Leg {
    /// No current.
    #[default]
    Idle,
    /// High-side switch on.
    HighSwitch,
    /// Low-side switch on.
    LowSwitch,
    /// Current from the motor through the high-side diode into the bus.
    HighDiode,
    /// Current from ground through the low-side diode into the motor.
    LowDiode,
}

impl Leg {
    pub(crate) const fn is_diode(self) -> bool {
        matches!(self, Self::HighDiode | Self::LowDiode)
    }

    /// 0 idle, 1 tied to the bus, 2 tied to ground.
    #[inline]
    pub(crate) const fn side(self) -> usize {
        match self {
            Self::Idle => 0,
            Self::HighSwitch | Self::HighDiode => 1,
            Self::LowSwitch | Self::LowDiode => 2,
        }
    }

    /// Sign of the diode's drop at the terminal: +1 above the bus, -1 below ground, 0 without a diode. Also the sign of the
    /// current that it does not let through.
    #[inline]
    pub(crate) const fn diode_sign(self) -> f64 {
        match self {
            Self::HighDiode => 1.0,
            Self::LowDiode => -1.0,
            _ => 0.0,
        }
    }
}

/// Currents into the motor and the bus voltage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Electric {
    pub(crate) i: [f64; 3],
    pub(crate) v: f64,
}

/// The same in the coordinates of a [`Wiring`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reduced {
    pub(crate) s: f64,
    pub(crate) d: f64,
    pub(crate) v: f64,
}

/// The circuit of three legs.
#[derive(Clone, Debug)]
pub(crate) struct Circuit {
    pub(crate) wiring: &'static Wiring,
    /// Any leg conducts through a diode.
    pub(crate) has_diodes: bool,
    /// Where, and in which direction.
    pub(crate) diodes: [f64; 3],
    /// The leg of the only diode, or of the first where two legs conduct and end together; 3 if there is none such.
    pub(crate) lone: usize,
    /// Parts of `s` and `d` in its current, positive where it would flow backwards.
    pub(crate) against: [f64; 2],
    /// Diode drops along the coordinates, and at the terminal of the one idle leg beside two that conduct, V.
    pub(crate) drop_s: f64,
    pub(crate) drop_d: f64,
    pub(crate) drop_idle: f64,
}

impl Circuit {
    /// The circuit of these legs with diodes that drop `drop` volts.
    pub(crate) fn new(legs: &[Leg; 3], drop: f64) -> Self {
        let wiring = Wiring::of(legs);
        let diodes = [legs[0].diode_sign(), legs[1].diode_sign(), legs[2].diode_sign()];
        let mut circuit = Self {
            wiring,
            has_diodes: legs[0].is_diode() || legs[1].is_diode() || legs[2].is_diode(),
            diodes,
            lone: 3,
            against: [0.0; 2],
            drop_s: 0.0,
            drop_d: 0.0,
            drop_idle: 0.0,
        };
        if circuit.has_diodes {
            circuit.add_diodes(legs, drop);
        }
        circuit
    }

    fn add_diodes(&mut self, legs: &[Leg; 3], drop: f64) {
        let Self { wiring, diodes, .. } = self;
        self.drop_s = drop * dot(&wiring.along, diodes);
        self.drop_d = drop * dot(&wiring.across, diodes);
        self.drop_idle = drop * dot(&wiring.mean, diodes);
        let mut with = (0..3).filter(|x| legs[*x].is_diode());
        if let Some(x) = with.next()
            && (wiring.conducting == 2 || with.next().is_none())
        {
            self.lone = x;
            self.against = [diodes[x] * wiring.along[x], diodes[x] * wiring.across[x]];
        }
    }

    /// A state in the circuit's coordinates.
    #[inline]
    pub(crate) fn reduce(&self, electric: &Electric) -> Reduced {
        Reduced { s: self.wiring.s_of(&electric.i), d: self.wiring.d_of(&electric.i), v: electric.v }
    }

    /// True while any leg is tied to bus or ground.
    #[inline]
    pub(crate) const fn is_tied(&self) -> bool {
        self.wiring.conducting > 0
    }

    /// Voltage of the star point: the conducting legs' terminal voltages less back-EMF average to it, because their
    /// currents sum to zero. With all legs idle the divider pulls the terminals to ground, and the low-side diodes hold the
    /// lowest one.
    pub(crate) fn neutral(&self, emf: &[f64; 3], v: f64, drop: f64) -> f64 {
        if self.is_tied() {
            return self.wiring.high_share * v + self.drop_idle - dot(&self.wiring.mean, emf);
        }
        (-drop - emf[0].min(emf[1]).min(emf[2])).max(0.0)
    }

    /// True if a diode's current flows backwards at `s` and `d`.
    #[inline]
    pub(crate) fn is_against_a_diode(&self, s: f64, d: f64) -> bool {
        let i = self.wiring.currents(s, d);
        self.diodes[0] * i[0] > 0.0 || self.diodes[1] * i[1] > 0.0 || self.diodes[2] * i[2] > 0.0
    }
}
