//! What adds up along a course: charge, torque impulse, and what the energy ledger needs.

use super::interval::Solved;
use super::ledger::Ledger;
use super::network::{Loop, Network};
use super::segment::Segment;
use super::stage::Stage;

/// Sums over a course.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Book {
    /// Torque impulse, N m s, and its moment about the start of the course, N m s2.
    pub(crate) impulse: f64,
    pub(crate) moment: f64,
    /// Way travelled as the circuit was told, rad.
    pub(crate) path: f64,
    /// Charge from the bus into the motor, A s.
    link: f64,
    /// Integral of the squares of all currents, A2 s.
    squares: f64,
    /// With the source on: the time, s, and integrals of w, the bus voltage from where it rests without the motor, V s, and of
    /// w^2 times the conductance at the bus, V A s.
    source_time: f64,
    fall: f64,
    fall_loss: f64,
    /// With the source off: integrals of the bus voltage, V s, and of its square, V2 s.
    volts: f64,
    volts_squared: f64,
}

impl Stage {
    /// Adds up what an interval moved.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn book(&mut self, segment: &Segment, solved: &Solved) {
        let Solved { h, per_h, end, sums, .. } = solved;
        let (network, start) = (&self.network, &segment.start);
        let book = &mut self.course.book;
        let twelfth = h * (1.0 / 12.0);
        // Of a parabola between a and b with mean m: mean square m^2 + (b - a)^2 / 12 and less than 1e-4 beside.
        let square = |sum: f64, rise: f64| sum * sum * per_h + twelfth * rise * rise;
        // Torque is back-EMF per speed times current along each coordinate, the current being such a parabola.
        let (s_rise, s_shape) = (end.s - start.s, &segment.shape.s);
        let mut impulse = s_shape.middle * sums.s + s_shape.slope * (h * twelfth) * s_rise;
        // along . along = 1 / k, across . across = 2.
        if segment.has_difference() {
            let (d_rise, d_shape) = (end.d - start.d, &segment.shape.d);
            impulse += d_shape.middle * sums.d + d_shape.slope * (h * twelfth) * d_rise;
            book.squares += 1.5 * square(sums.s, s_rise) + 2.0 * square(sums.d, d_rise);
        } else {
            book.squares += 2.0 * square(sums.s, s_rise);
        }
        book.impulse += impulse;
        book.moment += impulse * (self.course.elapsed + 0.5 * h);
        book.path += segment.middle_speed * h;
        if self.circuit.has_diodes {
            // A diode's drop is against its current.
            self.ledger.diodes -= self.circuit.drop_s * sums.s + self.circuit.drop_d * sums.d;
        }
        let is_open = segment.topology() == Loop::Open;
        if !is_open {
            book.link += sums.s;
        }
        if segment.source_on() {
            book.source_time += h;
            book.fall += sums.w;
            book.fall_loss += 0.5 * network.c * (start.v - end.v) * (start.v + end.v - 2.0 * network.rest());
            if !is_open {
                book.fall_loss -= network.link_power((*h, *per_h), segment, end, sums);
            }
        } else {
            book.volts += sums.w;
            book.volts_squared += square(sums.w, end.v - start.v);
        }
    }
}

impl Book {
    /// Enters what the network did in the ledger; returns the charge through the current shunt, A s.
    #[cfg_attr(not(target_arch = "wasm32"), inline(always))]
    pub(crate) fn enter(&self, network: &Network, ledger: &mut Ledger) -> f64 {
        let Network { source_v, source_g, leak_g, shunt_g, .. } = *network;
        let (rest, time) = (network.rest(), self.source_time);
        ledger.copper += network.copper * self.squares;
        ledger.switches += network.switch * self.squares;
        let squared = self.fall_loss * network.per_source_g();
        // Across the source resistance: what the leak takes at rest, and the fall from there.
        let leak = source_v - rest;
        ledger.source += source_v * source_g * (leak * time - self.fall);
        ledger.source_loss += source_g * (leak * (leak * time - 2.0 * self.fall) + squared);
        ledger.leak += leak_g * (rest * (rest * time + 2.0 * self.fall) + squared + self.volts_squared);
        self.link + shunt_g * (rest * time + self.fall + self.volts)
    }
}
