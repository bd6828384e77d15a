//! States of the three legs, and the circuit that follows from them until the next one changes.

use super::phase::Phase;
use super::wiring::{Wiring, dot};

/// State of a leg of the bridge.
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
    #[inline]
    pub(crate) const fn is_diode(self) -> bool {
        self as u8 >= Self::HighDiode as u8
    }

    /// 0 idle, 1 tied to the bus, 2 tied to ground.
    #[inline]
    pub(crate) const fn side(self) -> usize {
        const SIDES: [u8; 8] = [0, 1, 2, 1, 2, 0, 0, 0];
        SIDES[self as usize] as usize
    }

    /// Sign of the diode's drop at the terminal: +1 above the bus, -1 below ground, 0 without a diode. Also
    /// the sign of the current that it does not let through.
    #[inline]
    pub(crate) const fn diode_sign(self) -> f64 {
        const SIGNS: [f64; 8] = [0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0];
        SIGNS[self as usize]
    }
}

/// Currents into the motor and the bus voltage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Electric {
    pub(crate) i: [f64; 3],
    pub(crate) v: f64,
}

/// Currents into the motor and the bus voltage in the coordinates of a [`Wiring`].
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
    /// Legs that conduct through a diode, and the direction of each.
    pub(crate) diodes: [f64; 3],
    /// The leg of the only diode, or of the first where two legs conduct and end together.
    pub(crate) lone: Option<Phase>,
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
        let mut circuit = Self {
            wiring: Wiring::of(legs),
            has_diodes: true,
            diodes: [0.0; 3],
            lone: None,
            against: [0.0; 2],
            drop_s: 0.0,
            drop_d: 0.0,
            drop_idle: 0.0,
        };
        circuit.follow(legs, drop);
        circuit
    }

    /// Becomes the circuit of these legs.
    #[inline]
    pub(crate) fn follow(&mut self, legs: &[Leg; 3], drop: f64) {
        self.wiring = Wiring::of(legs);
        let [a, b, c] = legs.map(Leg::is_diode);
        let has_diodes = a | b | c;
        if has_diodes | self.has_diodes {
            self.has_diodes = has_diodes;
            self.lone = match (a, b, c) {
                (true, false, false) => Some(Phase::A),
                (false, true, false) => Some(Phase::B),
                (false, false, true) => Some(Phase::C),
                _ => None,
            };
            if has_diodes {
                self.follow_diodes(legs, drop);
            } else {
                (self.diodes, self.drop_s, self.drop_d, self.drop_idle) = ([0.0; 3], 0.0, 0.0, 0.0);
            }
        }
    }

    #[inline]
    fn follow_diodes(&mut self, legs: &[Leg; 3], drop: f64) {
        let wiring = self.wiring;
        self.diodes = [0.0; 3];
        if let Some(x) = self.lone {
            let sign = legs[x].diode_sign();
            self.diodes[x] = sign;
            self.against = [sign * wiring.along[x], sign * wiring.across[x]];
            (self.drop_s, self.drop_d) = (drop * self.against[0], drop * self.against[1]);
            self.drop_idle = drop * sign * wiring.mean[x];
        } else {
            self.follow_several(legs, drop);
        }
    }

    /// Several diodes.
    #[inline(never)]
    fn follow_several(&mut self, legs: &[Leg; 3], drop: f64) {
        let (wiring, diodes) = (self.wiring, legs.map(Leg::diode_sign));
        self.diodes = diodes;
        self.drop_s = drop * dot(&wiring.along, &diodes);
        self.drop_d = drop * dot(&wiring.across, &diodes);
        self.drop_idle = drop * dot(&wiring.mean, &diodes);
        if wiring.conducting == 2 {
            let first = if diodes[0] != 0.0 { Phase::A } else { Phase::B };
            self.lone = Some(first);
            self.against = [diodes[first] * wiring.along[first], 0.0];
        }
    }

    /// A state in the circuit's coordinates.
    #[inline]
    pub(crate) fn reduce(&self, electric: &Electric) -> Reduced {
        let d = if self.wiring.conducting == 3 { self.wiring.d_of(&electric.i) } else { 0.0 };
        Reduced { s: self.wiring.s_of(&electric.i), d, v: electric.v }
    }

    /// True while any leg is tied to bus or ground.
    #[inline]
    pub(crate) const fn is_tied(&self) -> bool {
        self.wiring.conducting > 0
    }

    /// Voltage of the star point: the conducting legs' terminal voltages less back-EMF average to it, because
    /// their currents sum to zero. With all legs idle the divider pulls the terminals to ground, and the
    /// low-side diodes hold the lowest one.
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
