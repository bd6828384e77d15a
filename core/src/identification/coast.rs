//! Back-EMF and friction, from the terminals of a motor that coasts.
//!
//! The star point floats and the lowest terminal is held by its diode, so the two higher ones show their
//! difference. It is 0 where they cross, three times an electrical revolution, and its integral from one
//! crossing to the next depends neither on the speed nor on the shape of a symmetrical back-EMF:
//!
//! ```text
//!  integral of (highest - second) = pi / 3 k / p
//! ```
//!
//! In the middle of such a third the second terminal is near the lowest and dips below ground, down to the
//! diode's voltage, where the converter reads 0. The time for which it is near ground tells how much that
//! hides: the diode's voltage times that time, less what the slopes at its ends make of it, which falls with
//! the square of the back-EMF. Straight lines between samples hide another part, which grows with the square
//! of the speed.
//!
//! The times of the crossings give the deceleration: `dw/dt = -(c + b w)`, integrated once, is
//! `w = w0 - c t - b angle`.

use super::fit::Fit;
use super::record::Record;
use core::f64::consts::{FRAC_PI_3, TAU};
use heapless::Vec;
use libm::{fmax, fmin, sqrt};

/// The new highest terminal must be this much above the old one to count, V.
const CLEAR: f64 = 0.05;
/// Voltage of the diode that holds the lowest terminal, V.
const DIODE: f64 = 0.8;
/// A terminal that reads less than this may be below ground, V.
const LOW: f64 = 0.1;
/// `DIODE` times the time below `LOW` counts the slopes in full: too much by this share of the flux over the
/// square of the back-EMF, V2. `DIODE (DIODE + 2 LOW)` for a sine, half as much for a trapezoid.
const SLOPES: f64 = 0.7;
/// Share that straight lines cut off, over the square of the angle between two samples. The trapezoidal rule
/// loses `h^2 / 12` of the change of slope, which from crossing to crossing is `2 k w` for every shape.
const CHORD: f64 = 0.16;
/// Thirds at less than this share of the largest speed tell the deceleration alone.
const FAST: f64 = 0.7;
/// Largest standard error of the flux, as a share.
const UNSURE: f64 = 0.03;
/// A third that is seen in fewer samples tells nothing.
const SAMPLES: usize = 4;
/// Fewest thirds: three revolutions, each a third later than the one before.
const LEAST: usize = 5;
/// Angle of a third.
const THIRD: f64 = TAU / 3.0;
/// Most thirds that are kept.
const THIRDS: usize = 256;

/// A coasting rotor. Speeds and angles are electrical.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coast {
    /// Integral of one third, Vs, and its standard error.
    pub(super) flux: (f64, f64),
    /// Speed when the bridge went off, rad/s.
    pub(super) speed: f64,
    /// Mean speed of what was recorded, rad/s.
    pub(super) mean: f64,
    /// Coulomb friction and viscous friction over inertia: `c`, rad/s2, and `b`, 1/s.
    pub(super) friction: (f64, f64),
    /// Standard error of the deceleration at the mean speed, rad/s2.
    pub(super) error: f64,
    /// Standard error of `b`, 1/s.
    pub(super) split: f64,
}

/// One third of an electrical revolution.
#[derive(Clone, Copy, Debug)]
struct Third {
    flux: f64,
    /// s.
    begin: f64,
    end: f64,
    /// Time for which the second terminal reads less than `LOW`, s.
    low: f64,
}

impl Third {
    /// rad/s.
    fn speed(&self) -> f64 {
        THIRD / (self.end - self.begin)
    }

    /// The integral with what was hidden. interval: from one sample to the next, s.
    fn whole_flux(&self, interval: f64) -> f64 {
        let speed = self.speed();
        let step = speed * interval;
        let seen = self.flux * (1.0 + CHORD * step * step) + DIODE * self.low;
        // whole (1 + SLOPES / E^2) = seen, with E of the whole flux.
        let per_flux = speed / FRAC_PI_3;
        let slopes = SLOPES / (per_flux * per_flux);
        (seen + sqrt(fmax(seen * seen - 4.0 * slopes, 0.0))) / 2.0
    }
}

impl Coast {
    /// Back-EMF constant of a motor with these pole pairs, V s/rad, and its standard error.
    pub(super) fn torque_constant(&self, pole_pairs: f64) -> (f64, f64) {
        let (flux, error) = self.flux;
        (flux * pole_pairs / FRAC_PI_3, error * pole_pairs / FRAC_PI_3)
    }

    /// This one and a later one, each by its more certain part.
    pub(super) fn with(self, later: Self) -> Self {
        let flux = if later.flux.1 < self.flux.1 { later.flux } else { self.flux };
        if later.error < self.error { Self { flux, ..later } } else { Self { flux, ..self } }
    }

    /// Of a record of the three terminals from the stop on; `None` if fewer than five thirds were seen.
    pub(super) fn of(record: &Record) -> Option<Self> {
        let thirds = thirds(record);
        let [first, .., last] = thirds.as_slice() else { return None };
        if thirds.len() < LEAST {
            return None;
        }
        let fastest = thirds.iter().map(Third::speed).fold(0.0, fmax);
        let mut flux = Fit::default();
        for third in thirds.iter().filter(|third| third.speed() > FAST * fastest) {
            flux.add(&[1.0], third.whole_flux(record.interval), 1.0);
        }
        let flux = flux.solve()?;
        // A single third has no error, and may be any.
        if flux.error[0] == 0.0 || flux.error[0] > UNSURE * flux.value[0] {
            return None;
        }
        let mean = (first.speed() + last.speed()) / 2.0;
        let (friction, begin, error, split) = friction(&thirds, mean)?;
        Some(Self {
            flux: (flux.value[0], flux.error[0]),
            speed: begin,
            mean,
            friction,
            error,
            split: fmin(split, (friction.0 + friction.1 * mean) / mean),
        })
    }
}

/// `c`, `b`, the speed at time 0, and the standard errors of the deceleration and of `b`. Friction never
/// drives: a `b` or a `c` below 0 is taken as 0. mean: speed, rad/s.
fn friction(thirds: &[Third], mean: f64) -> Option<((f64, f64), f64, f64, f64)> {
    let (mut both, mut line) = (Fit::default(), Fit::default());
    // By whole revolutions: an offset of one terminal makes the thirds differ in length.
    for (number, window) in thirds.windows(3).enumerate() {
        let [first, _, last] = window else { return None };
        let time = (first.begin + last.end) / 2.0;
        let (angle, speed) = ((number as f64 + 1.5) * THIRD, TAU / (last.end - first.begin));
        both.add(&[1.0, -time, -angle], speed, 1.0);
        line.add(&[1.0, -time], speed, 1.0);
    }
    // The deceleration in the mean is what a straight line shows; its two parts are less certain.
    let line = line.solve()?;
    let [begin, deceleration, ..] = line.value;
    let both = both.solve();
    let split = both.map_or(f64::INFINITY, |fit| fit.error[2]);
    let friction = match both.map(|fit| fit.value) {
        Some([_, c, ..]) if c < 0.0 => (0.0, deceleration / mean),
        Some([_, c, b, ..]) if b >= 0.0 => (c, b),
        _ => (deceleration, 0.0),
    };
    Some((friction, begin, line.error[1], split))
}

/// The thirds between crossings that follow each other in one sense.
fn thirds(record: &Record) -> Vec<Third, THIRDS> {
    let mut thirds = Vec::new();
    let mut before: Option<[f64; 3]> = None;
    let mut top: Option<usize> = None;
    let mut sense = None;
    // The crossing that began this third, and the integral since.
    let mut begun: Option<f64> = None;
    let (mut area, mut samples, mut low) = (0.0, 0, 0.0);
    // The last crossing of a candidate with the present top, and the integral at it.
    let mut crossed: Option<(usize, f64, f64)> = None;
    for (number, terminals) in record.rows::<3>().enumerate() {
        let time = number as f64 * record.interval;
        let highest = largest(&terminals);
        // The winding's current is gone a few samples after the stop.
        if number < SKIPPED {
            continue;
        }
        let Some(present) = top else {
            (top, before) = (Some(highest), Some(terminals));
            continue;
        };
        let last = before.replace(terminals).unwrap_or(terminals);
        let step = (lead(&last, present) + lead(&terminals, present)) / 2.0 * record.interval;
        if highest != present && crossed.is_none_or(|(other, ..)| other != highest) {
            let (was, is) =
                (of(&last, present) - of(&last, highest), of(&terminals, highest) - of(&terminals, present));
            let share = was / fmax(was + is, 1e-9);
            let at = time - (1.0 - share) * record.interval;
            // Up to the crossing the difference falls to 0.
            crossed = Some((highest, at, area + fmax(was, 0.0) * share * record.interval / 2.0));
        }
        area += step;
        samples += 1;
        if second(&terminals, present) < LOW {
            low += record.interval;
        }
        let Some((other, at, until)) = crossed else { continue };
        if highest == present {
            // It was noise.
            crossed = None;
        } else if of(&terminals, other) - of(&terminals, present) > CLEAR {
            let turned = (other + 3 - present) % 3;
            if *sense.get_or_insert(turned) != turned || (begun.is_some() && samples < SAMPLES) {
                break;
            }
            if let Some(begin) = begun
                && thirds.push(Third { flux: until, begin, end: at, low }).is_err()
            {
                break;
            }
            (begun, top, crossed, samples, low) = (Some(at), Some(other), None, 0, 0.0);
            // From the crossing on the difference rises from 0.
            let above = of(&terminals, other) - second(&terminals, other);
            area = above * (time - at) / 2.0;
        }
    }
    thirds
}

/// Samples after the stop in which the winding's current may still flow.
const SKIPPED: usize = 12;

fn largest(terminals: &[f64; 3]) -> usize {
    let [a, b, c] = *terminals;
    if a >= b && a >= c {
        0
    } else if b >= c {
        1
    } else {
        2
    }
}

/// The voltage of a terminal, counted round.
const fn of(terminals: &[f64; 3], terminal: usize) -> f64 {
    terminals[terminal % 3]
}

/// The second highest, if `top` is the highest.
fn second(terminals: &[f64; 3], top: usize) -> f64 {
    fmax(of(terminals, top + 1), of(terminals, top + 2))
}

/// Voltage by which `top` is above the other two; 0 once another one is.
fn lead(terminals: &[f64; 3], top: usize) -> f64 {
    fmax(of(terminals, top) - second(terminals, top), 0.0)
}
