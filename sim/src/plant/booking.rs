//! Sums over intervals: charge, torque impulse, and the terms of the energy ledger.

use super::interval::Solved;
use super::ledger::Ledger;
use super::network::{Loop, Network};
use super::segment::Segment;
use super::stage::Stage;

/// Sums over the network since it was last entered in the ledger.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Book {
    /// Charge from the bus into the motor, A s.
    link: f64,
    /// Integral of the squares of all currents, A2 s.
    squares: f64,
    /// With the source on: the time, s, and integrals of w, the bus voltage from where it rests without the
    /// motor, V s, and of w^2 times the conductance at the bus, V A s.
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
        let book = &mut self.book;
        let twelfth = h * (1.0 / 12.0);
        // Of a parabola between a and b with mean m: mean square m^2 + (b - a)^2 / 12 and less than 1e-4
        // beside.
        let square = |sum: f64, rise: f64| sum * sum * per_h + twelfth * rise * rise;
        // Torque is back-EMF per speed times current along each coordinate, the current being such a
        // parabola.
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
        let course = &mut self.course;
        course.impulse += impulse;
        course.moment += impulse * (course.elapsed + 0.5 * h);
        course.path += segment.middle_speed * h;
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

impl Stage {
    /// Enters in the ledger what the network moved: before anything of it changes.
    pub(crate) fn enter_book(&mut self) {
        self.shunt_charge = self.charge();
        self.ledger = self.ledger_now();
        self.book = Book::default();
    }

    /// Charge through the current shunt since the start, A s.
    #[inline]
    pub(crate) fn charge(&self) -> f64 {
        let (network, book) = (&self.network, &self.book);
        let at_bus = network.rest() * book.source_time + book.fall + book.volts;
        self.shunt_charge + book.link + network.shunt_g * at_bus
    }

    /// The ledger with all that the network moved.
    pub(crate) fn ledger_now(&self) -> Ledger {
        let Book { squares, source_time: time, fall, fall_loss, volts_squared, .. } = self.book;
        let Network { copper, switch, source_v, source_g, leak_g, .. } = self.network;
        let rest = self.network.rest();
        let squared = fall_loss * self.network.per_source_g();
        // Across the source resistance: what the leak takes at rest, and the fall from there.
        let leak = source_v - rest;
        let before = &self.ledger;
        Ledger {
            copper: before.copper + copper * squares,
            switches: before.switches + switch * squares,
            source: before.source + source_v * source_g * (leak * time - fall),
            source_loss: before.source_loss + source_g * (leak * (leak * time - 2.0 * fall) + squared),
            leak: before.leak + leak_g * (rest * (rest * time + 2.0 * fall) + squared + volts_squared),
            ..*before
        }
    }
}
