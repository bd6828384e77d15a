//! Resistance and inductance, from a rotor that is held with direct current and let go.
//!
//! While it is held, pulses of the duty D leave a current whose mean on the bus is, with the winding's time
//! constant tau = L / R and the PWM period T,
//!
//! ```text
//!  I = V / R (D - tau / T (1 - exp(-D T / tau)) (1 - exp(-(1 - D) T / tau)) / (1 - exp(-T / tau)))
//! ```
//!
//! Several levels give R, and the part of the duty that dead time takes. When the bridge goes off, the
//! current returns to the bus through two diodes. The charge that comes back gives L: it needs no fast
//! measurement, because a filter keeps it.

use super::record::Record;
use heapless::Vec;
use libm::{exp, fabs, fmax, fmin, log};

/// Voltage of a silicon diode that carries the current, V. The charge depends on it by a few per cent.
const DIODE: f64 = 0.8;
/// From the end of a pulse to the sample of the off-time, s (`sample_settle` of the drive).
const SETTLE: f64 = 3e-6;
/// From the beginning of a period until the drive's answer acts, s.
const EARLIEST: f64 = 12.5e-6;
/// Up to this duty the drive reads the current after the pulse, from the other one on in its middle.
pub(super) const OFF_TIME: f64 = 0.19;
pub(super) const ON_TIME: f64 = 0.27;

/// One level: the rotor held, then let go.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lock {
    /// Duty that was asked for, 0 to 1.
    pub(super) level: f64,
    /// Duty as commanded, with what the drive adds for its dead time.
    pub(super) duty: f64,
    /// Bus voltage, V.
    pub(super) voltage: f64,
    /// Mean bus current, A.
    pub(super) current: f64,
    /// Bus voltage after the charge has returned, V.
    pub(super) raised: f64,
    /// Charge that returned after the last reading of a pulse, A times the period, and the number of readings
    /// that it is the sum of.
    charge: f64,
    readings: f64,
    /// Reading of the current channel without a current, A.
    pub(super) zero: f64,
    /// Standard deviation of one reading of the current, A.
    pub(super) noise: f64,
}

/// Resistance and inductance, line to line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Winding {
    /// With the switches, ohm.
    pub(super) resistance: f64,
    pub(super) inductance: f64,
    /// Duty that dead time takes.
    pub(super) lost: f64,
    /// Largest deviation of one level's resistance and inductance from these, relative.
    pub(super) spread: (f64, f64),
}

impl Lock {
    /// Of a record of bus voltage, duty and current of one period; the bridge goes off after `before` rows.
    pub(super) fn of(record: &Record, before: usize, level: f64) -> Option<Self> {
        let rows = || record.rows::<3>();
        let held = before.checked_sub(4)?;
        let count = held as f64;
        let mut sums = [0.0; 3];
        for row in rows().take(held) {
            for (sum, value) in sums.iter_mut().zip(row) {
                *sum += value / count;
            }
        }
        let [voltage, duty, held_current] = sums;
        // The last rows show the current channel's zero: nothing flows any more.
        let rest = rows().rev().take(TAIL);
        let zero = rest.map(|[_, _, current]| current).sum::<f64>() / TAIL as f64;
        let noise = libm::sqrt(
            rows().take(held).map(|[_, _, i]| (i - held_current) * (i - held_current)).sum::<f64>() / count,
        );
        let duty = duty / 100.0;
        // A reading is the mean since the reading before. The last of the pulses was read after the pulse or
        // in its middle, the next one early in its period.
        let off = rows().take(before + 4).position(|[_, duty, _]| duty == 0.0)?;
        let raised =
            rows().skip(off + 2).take(RAISED).map(|[voltage, ..]| voltage).sum::<f64>() / RAISED as f64;
        let (mut charge, mut readings) = (0.0, 0.0);
        for (at, [_, _, current]) in rows().enumerate().skip(off + 1) {
            let (returned, first) = (zero - current, at == off + 1);
            if returned < CLEAR * noise && !first {
                break;
            }
            readings += 1.0;
            charge += returned * if first && level <= OFF_TIME { 1.0 - duty / 2.0 } else { 1.0 };
        }
        Some(Self {
            level,
            duty,
            voltage,
            current: held_current - zero,
            zero,
            raised,
            charge,
            readings,
            noise,
        })
    }
}

/// Standard deviation of what a drive takes for its dead time, as a duty.
const DEAD_TIME: f64 = 1e-3;
/// Rows at the end of a record in which nothing flows.
const TAIL: usize = 160;
/// Rows after the stop that show how far the bus has risen.
const RAISED: usize = 8;
/// A current that is less than this many standard deviations of a reading is none.
const CLEAR: f64 = 4.0;

/// Steady current of pulses.
#[derive(Clone, Copy, Debug)]
struct Pulses {
    /// Share of the period.
    duty: f64,
    /// Period over the winding's time constant.
    length: f64,
}

impl Pulses {
    /// Mean current on the bus, in V / R.
    fn bus(self) -> f64 {
        let Self { duty, length } = self;
        let (on, off) = (1.0 - exp(-duty * length), 1.0 - exp(-(1.0 - duty) * length));
        duty - on * off / (length * (1.0 - exp(-length)))
    }

    /// Current at the end of a pulse, in V / R.
    fn crest(self) -> f64 {
        (1.0 - exp(-self.duty * self.length)) / (1.0 - exp(-self.length))
    }

    /// Current within a pulse, after `share` of the period, in V / R.
    fn rising(self, share: f64) -> f64 {
        1.0 - (1.0 - self.trough()) * exp(-share * self.length)
    }

    /// Charge that flows from `begin` to `end` of a pulse, shares of the period, in V / R times the period.
    fn flows(self, begin: f64, end: f64) -> f64 {
        end - begin - (self.rising(end) - self.rising(begin)) / self.length
    }

    /// Current at the beginning of a pulse, in V / R.
    fn trough(self) -> f64 {
        self.crest() * exp(-(1.0 - self.duty) * self.length)
    }
}

/// R and L of several levels; `None` where they fit no winding. period: of the PWM, s.
pub(super) fn solve(locks: &[Lock], period: f64) -> Option<Winding> {
    let strongest = locks.iter().map(|lock| lock.current * lock.voltage).fold(0.0, fmax);
    let mut used = Vec::<Lock, 8>::from_slice(locks).ok()?;
    used.retain(|lock| lock.current * lock.voltage > 0.02 * strongest);
    // From a long time constant on, in turns: R for this L, L for this R.
    let mut winding = Winding { resistance: 0.0, inductance: 0.0, lost: 0.0, spread: (0.0, 0.0) };
    let mut constant = 10.0 * period;
    for _ in 0..12 {
        (winding.resistance, winding.lost) = resistance(&used, period / constant)?;
        winding.inductance = inductance(&used, &winding, period)?;
        constant = winding.inductance / winding.resistance;
    }
    let mut spread = (0.0, 0.0);
    for lock in &used {
        let alone = Pulses { duty: lock.duty - winding.lost, length: period / constant }.bus() * lock.voltage
            / lock.current;
        spread.0 = fmax(spread.0, fabs(alone / winding.resistance - 1.0));
        if lock.current * lock.voltage > 0.4 * strongest {
            let alone = inductance(&[*lock], &winding, period)?;
            spread.1 = fmax(spread.1, fabs(alone / winding.inductance - 1.0));
        }
    }
    Some(Winding { spread, ..winding })
}

/// Levels that are strong enough to show L.
fn strong(locks: &[Lock]) -> impl Iterator<Item = &Lock> {
    let strongest = locks.iter().map(|lock| lock.current * lock.voltage).fold(0.0, fmax);
    locks.iter().filter(move |lock| lock.current * lock.voltage > 0.4 * strongest)
}

/// Standard deviation of the charge that shows L, as a share of it: each reading has its noise.
pub(super) fn doubt(locks: &[Lock]) -> f64 {
    let (charge, square) = strong(locks).fold((0.0, 0.0), |(charge, square), lock| {
        (charge + lock.charge, square + lock.readings * lock.noise * lock.noise)
    });
    libm::sqrt(square) / charge
}

/// R and the lost duty that fit the currents best, for pulses of this `length` (T / tau).
fn resistance(locks: &[Lock], length: f64) -> Option<(f64, f64)> {
    // The drive knows its dead time well, the currents show it less well at low levels.
    let mean = |of: &dyn Fn(&Lock) -> f64| locks.iter().map(of).sum::<f64>() / locks.len() as f64;
    let (known, reading) = (mean(&|lock| lock.duty - lock.level), mean(&|lock| lock.noise));
    let unsure = reading / libm::sqrt(TAIL as f64) / DEAD_TIME;
    let most = locks.iter().map(|lock| lock.duty).fold(1.0, fmin);
    // For a lost duty the conductance is a linear fit; its error has one minimum.
    let fit = |lost: f64| {
        let (mut of, mut square, mut error) = (0.0, 0.0, 0.0);
        for lock in locks {
            let model = lock.voltage * Pulses { duty: fmax(lock.duty - lost, 0.0), length }.bus();
            of += model * lock.current;
            square += model * model;
            error += lock.current * lock.current;
        }
        let away = (lost - known) * unsure;
        (of / square, error - of * of / square + away * away)
    };
    let (mut low, mut high) = (0.0, 0.9 * most);
    const GOLDEN: f64 = 0.618;
    for _ in 0..40 {
        let (left, right) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if fit(left).1 < fit(right).1 { high = right } else { low = left }
    }
    let lost = (low + high) / 2.0;
    let resistance = 1.0 / fit(lost).0;
    (resistance.is_finite() && resistance > 0.0).then_some((resistance, lost))
}

/// L whose energy returns the charge that was seen at the stronger levels.
fn inductance(locks: &[Lock], winding: &Winding, period: f64) -> Option<f64> {
    let seen: f64 = strong(locks).map(|lock| lock.charge * period).sum();
    let returned = |inductance: f64| -> f64 {
        strong(locks).map(|lock| charge(lock, winding, inductance, period)).sum()
    };
    let (mut low, mut high) = (1e-7, 1.0);
    if seen <= returned(low) || seen >= returned(high) {
        return None;
    }
    for _ in 0..60 {
        let middle = libm::sqrt(low * high);
        if returned(middle) < seen { low = middle } else { high = middle }
    }
    Some(low)
}

/// Charge that is seen to return to the bus after the last reading of a pulse, As:
/// `L di/dt = -(V + 2 Vd + R i)` from the current at the stop to one that is lost in the noise.
fn charge(lock: &Lock, winding: &Winding, inductance: f64, period: f64) -> f64 {
    let r = winding.resistance;
    let constant = inductance / r;
    let pulses = Pulses { duty: fmax(lock.duty - winding.lost, 0.0), length: period / constant };
    let full = lock.voltage / r;
    // The pulse is centred on the period's boundary. Read in its middle, it goes on until the bridge goes
    // off; read after it, the current circulates until then.
    let (current, flowed) = if lock.level > OFF_TIME {
        let middle = pulses.duty / 2.0;
        let stop = fmin(middle + EARLIEST / period, pulses.duty);
        (full * pulses.rising(stop), full * pulses.flows(middle, stop) * period)
    } else {
        let stop = fmax(lock.duty / 2.0 * period + SETTLE, EARLIEST);
        (full * pulses.crest() * exp(-(stop - pulses.duty / 2.0 * period) / constant), 0.0)
    };
    let against = (lock.voltage + lock.raised) / 2.0 + 2.0 * DIODE;
    let until = fmin(CLEAR * lock.noise, current);
    let time = constant * log((against + current * r) / (against + until * r));
    (inductance * (current - until) - against * time) / r - flowed
}
