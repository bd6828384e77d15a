//! The figures that were found, with their uncertainties.

use super::winding::{self, Winding};
use super::{Figure, Found, Identification, Identified, Turned};
use libm::fmax;

/// Share by which the bridge's resistance may be off.
const BRIDGE: f64 = 0.25;

impl Identification {
    /// The result, from everything that was found.
    pub(super) fn identified(&self, winding: &Winding) -> Identified {
        let Found { supply, current, .. } = self.found;
        let resistance = winding.resistance - self.asked.bridge;
        Identified {
            pole_pairs: self.found.pole_pairs,
            temperature: self.found.temperature,
            supply,
            current,
            resistance: Figure {
                value: resistance,
                uncertainty: fmax(0.01, winding.spread.0) * resistance + BRIDGE * self.asked.bridge,
            },
            inductance: Figure {
                value: winding.inductance,
                uncertainty: (0.05 + winding.spread.1 + 2.0 * winding::doubt(&self.locks))
                    * winding.inductance,
            },
            turned: self.turned(),
            halls: self.found.halls,
        }
    }

    fn turned(&self) -> Option<Turned> {
        let driven = self.found.driven?;
        let (k, error) = self.found.torque_constant;
        let relative = |value: f64, uncertainty: f64| Figure { value, uncertainty: uncertainty * value };
        let (inertia, uncertainty) = driven.inertia;
        let ((static_friction, viscous_friction), (speed, unsure)) = (driven.friction, driven.known);
        Some(Turned {
            torque_constant: Figure { value: k, uncertainty: 0.01 * k + 3.0 * error },
            inertia: relative(inertia, uncertainty),
            friction: relative(static_friction + viscous_friction * speed, unsure),
            static_friction,
            viscous_friction,
            speed,
        })
    }
}
