//! Inertia and friction, from the power that accelerates the rotor.
//!
//! The energy of the bus becomes kinetic energy, friction and heat:
//!
//! ```text
//!  V I dt = J w dw + (T + B (w - wm)) w dt + V z dt + h H dt
//! ```
//!
//! with the friction torque `T` at the mean speed `wm` of the coasting rotor, its slope `B`, the error `z` of
//! the current channel's zero, and the heat `H` that the winding's resistance tells, times `h`. Where the
//! bridge pulses with the duty `D`, its voltage is that of the winding:
//!
//! ```text
//!  V D - R (I - z) / D = k w (1 + c)
//! ```
//!
//! with the known torque constant `k` and what commutation takes, `c`. A small motor takes few milliamperes
//! from the bus, and this tells `z` better than the channel itself.
//!
//! The record is cut into blocks, and each is two equations for the six unknowns `J`, `T`, `B`, `z`, `h` and
//! `c`. What is known beside the record counts as equations, too: the friction over inertia of the coasting
//! rotor, a zero of 0, a heat as computed, and a `c` of 0. Each has the weight of its uncertainty.

use super::channel::{Channel, ZERO};
use super::coast::Coast;
use super::fit::Fit;
use super::record::Record;
use super::winding::Winding;
use core::f64::consts::TAU;
use libm::{exp, fabs, fmax, fmin, round};

/// Blocks of a record.
const BLOCKS: usize = 16;
/// Rows at each end that tell the speed before and after.
const ENDS: usize = 24;
/// Least rise of the speed, as a share of the speed at its end.
const LEAST: f64 = 0.2;

/// Time constant of the bus current's filter, s.
const FILTER: f64 = 6.4e-3;
/// The speed is the mean of the last electrical revolution, and shows it so many of these later.
const LAG: f64 = 0.58;

/// Standard deviation of the heat, as a share: commutation and switches add to that of the winding.
const HEAT: f64 = 0.1;
/// Standard deviation of a speed, as a share.
const JITTER: f64 = 5e-3;
/// Standard deviation of a block's energy, as a share: what the equation leaves out.
const MODEL: f64 = 0.02;
/// Standard deviation of the coasting rotor's friction: so many standard errors, because those of
/// neighbouring thirds are not independent, or this share at least.
const COASTED: (f64, f64) = (1.5, 0.02);
/// A duty below this drives no current.
const THIN: f64 = 0.01;
/// Standard deviations of the back-EMF that duty and current tell: of all blocks alike, because commutation
/// takes some, as a share; of one block, as a share; and what dead time leaves, as a duty.
const DROPS: f64 = 0.1;
const BEMF: f64 = 0.04;
const DEAD_TIME: f64 = 3e-3;
/// Relative uncertainty of inertia and friction at best.
const FLOOR: f64 = 0.04;

/// Figures that an acceleration shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Driven {
    /// Inertia, kg m2, and its relative uncertainty.
    pub(super) inertia: (f64, f64),
    /// Coulomb friction, N m, and viscous friction, N m s/rad.
    pub(super) friction: (f64, f64),
    /// A speed, rad/s, and relative uncertainty of the friction there.
    pub(super) known: (f64, f64),
}

impl Driven {
    /// One acceleration that no second one has confirmed: twice as uncertain.
    pub(super) fn alone(self) -> Self {
        let twice = |(value, off): (f64, f64)| (value, 2.0 * off);
        Self { inertia: twice(self.inertia), known: twice(self.known), ..self }
    }

    /// The mean of two accelerations, weighted by their certainty. Their errors may have one cause, so the
    /// mean is no more certain than the better one.
    pub(super) fn mean(self, other: Self) -> Self {
        let weighted = |one: f64, two: f64, off: f64, away: f64| {
            let (left, right) = (1.0 / square(off), 1.0 / square(away));
            (one * left + two * right) / (left + right)
        };
        let ((one, off), (two, away)) = (self.inertia, other.inertia);
        let friction = |one: f64, two: f64| weighted(one, two, self.known.1, other.known.1);
        Self {
            inertia: (weighted(one, two, off, away), fmin(off, away)),
            friction: (
                friction(self.friction.0, other.friction.0),
                friction(self.friction.1, other.friction.1),
            ),
            known: (other.known.0, fmin(self.known.1, other.known.1)),
        }
    }
}

/// Balance of a block: energy of the bus and heat of the winding, J, bus voltage and back-EMF over time, V s,
/// and what inertia and friction are multiplied with.
#[derive(Clone, Copy, Debug, Default)]
struct Block {
    energy: f64,
    heat: f64,
    volts: f64,
    back_emf: f64,
    /// Way of the rotor while it was driven, rad.
    driven: f64,
    /// Share of an error of the zero in the back-EMF over time, V s/A.
    per_zero: f64,
    /// Half of the rise of the squared speed.
    rise: f64,
    /// Integrals of the speed and of its square.
    turned: (f64, f64),
    /// Speed at its end, rad/s.
    speed: f64,
}

/// The equations of an acceleration.
#[derive(Clone, Copy, Debug)]
pub(super) struct Balance {
    fit: Fit,
    /// Inertia by the balance of the whole record, kg m2: the scale of the weights.
    scale: f64,
    /// Speed at which the friction torque is an unknown, rad/s.
    middle: f64,
    pole_pairs: f64,
    /// Torque constant, V s/rad: `(V D - R i) / w` in the last block. It is high by what commutation drops.
    pub(super) torque_constant: f64,
}

impl Balance {
    /// Those of a record of speed, bus voltage, bus current and duty; `None` if the speed hardly rises.
    /// period: of the PWM, s.
    pub(super) fn of(
        record: &Record,
        winding: &Winding,
        coast: &Coast,
        channel: Channel,
        pole_pairs: f64,
        period: f64,
    ) -> Option<Self> {
        let (blocks, time) = blocks(record, winding, channel, pole_pairs, period)?;
        let (c, b) = (coast.friction.0 / pole_pairs, coast.friction.1);
        let middle = coast.mean / pole_pairs;
        let (known, _) = coast.torque_constant(pole_pairs);
        let energy: f64 = blocks.iter().map(|block| block.energy - block.heat).sum();
        let slowed = |block: &Block| block.rise + c * block.turned.0 + b * block.turned.1;
        let scale = energy / blocks.iter().map(slowed).sum::<f64>();
        if !(scale.is_finite() && scale > 0.0) {
            return None;
        }
        let mut fit = Fit::default();
        for (place, value, deviation) in [(3, 0.0, ZERO), (4, 1.0, HEAT), (5, 0.0, DROPS)] {
            fit.know(place, value, weight(deviation));
        }
        for block in &blocks {
            let volts = block.volts / time;
            let noise = square(channel.noise) * volts * block.volts * period;
            let jitter = 2.0 * square(scale * square(block.speed) * JITTER);
            let (angle, squares) = block.turned;
            let row = [block.rise, angle, squares - middle * angle, block.volts, block.heat, 0.0];
            fit.add(&row, block.energy, 1.0 / (noise + jitter + square(MODEL * block.energy)));
            let back_emf = known * block.driven;
            if back_emf > 0.0 {
                let row = [0.0, 0.0, 0.0, -block.per_zero, 0.0, back_emf];
                let pulses = DEAD_TIME * block.volts;
                let noise = square(block.per_zero * channel.noise) * period / time;
                fit.add(
                    &row,
                    block.back_emf - back_emf,
                    1.0 / (noise + square(BEMF * back_emf) + square(pulses)),
                );
            }
        }
        let last = blocks.last()?;
        let torque_constant = last.back_emf / last.driven;
        Some(Self { fit, scale, middle, pole_pairs, torque_constant })
    }

    /// Inertia and friction with the friction over inertia of a coasting rotor; `None` if they cannot be told
    /// apart.
    pub(super) fn solve(mut self, coast: &Coast) -> Option<Driven> {
        let (c, b) = (coast.friction.0 / self.pole_pairs, coast.friction.1);
        let mean = coast.mean / self.pole_pairs;
        let deceleration = c + b * mean;
        let coasted = fmax(COASTED.0 * coast.error / self.pole_pairs, COASTED.1 * deceleration);
        let split = fmax(COASTED.0 * coast.split, COASTED.1 * b);
        let away = mean - self.middle;
        self.fit.add(&[-deceleration, 1.0, away, 0.0, 0.0, 0.0], 0.0, weight(coasted * self.scale));
        self.fit.add(&[-b, 0.0, 1.0, 0.0, 0.0, 0.0], 0.0, weight(split * self.scale));
        let fit = self.fit.solve()?;
        let [inertia, torque, slope, ..] = fit.value;
        // Friction never drives.
        let viscous = fmin(fmax(slope, 0.0), torque / self.middle);
        let relative = |place: usize| FLOOR + 2.0 * fit.error[place] / fit.value[place];
        (inertia > 0.0 && torque > 0.0).then_some(Driven {
            inertia: (inertia, relative(0)),
            friction: (torque - viscous * self.middle, viscous),
            known: (self.middle, relative(1)),
        })
    }
}

/// The blocks of a record, and the time of each, s; `None` if the speed hardly rises.
fn blocks(
    record: &Record,
    winding: &Winding,
    channel: Channel,
    pole_pairs: f64,
    period: f64,
) -> Option<([Block; BLOCKS], f64)> {
    let interval = record.interval;
    let shown = |row: usize| record.row::<4>(row).map_or(0.0, |[rpm, ..]| fabs(rpm) * TAU / 60.0);
    let mean = |first: usize| (first..first + ENDS).map(shown).sum::<f64>() / ENDS as f64;
    let count = record.len::<4>();
    let (begin, end) = (mean(0), mean(count.checked_sub(ENDS)?));
    if begin <= 0.0 || end - begin < LEAST * end {
        return None;
    }
    let rows_in = |time: f64| round(time / interval) as usize;
    let lag = |speed: f64| rows_in(LAG * TAU / (fmax(speed, 0.5 * begin) * pole_pairs));
    let delay = rows_in(FILTER);
    let length = count.checked_sub(delay + lag(begin) + 1)? / BLOCKS;
    // Speeds pass the filter that the current has passed.
    let passes = 1.0 - exp(-interval / FILTER);
    let mut seen = [square(begin) / 2.0, -begin * FILTER, -square(begin) * FILTER];
    let (mut angle, mut squares) = (0.0, 0.0);
    let mut blocks = [Block::default(); BLOCKS];
    for (number, block) in blocks.iter_mut().enumerate() {
        let before = seen;
        for row in number * length..(number + 1) * length {
            let [_, voltage, current, _] = record.row(row)?;
            // The winding's heat needs a current and a duty of the same time.
            let [.., duty] = record.row::<4>(row.saturating_sub(delay))?;
            let speed = shown(row + lag(shown(row)));
            let (current, duty) = (current - channel.zero, duty / 100.0 - winding.lost);
            if duty > THIN {
                let per_current = winding.resistance / duty;
                block.back_emf += (voltage * duty - per_current * current) * interval;
                block.per_zero += per_current * interval;
                block.driven += speed * interval;
                let ripple = voltage * duty * (1.0 - duty) * period / winding.inductance;
                let heat = winding.resistance * (square(current / duty) + square(ripple) / 12.0);
                block.heat += heat * interval;
            }
            block.energy += voltage * current * interval;
            block.volts += voltage * interval;
            block.speed = speed;
            angle += speed * interval;
            squares += square(speed) * interval;
            for (seen, now) in seen.iter_mut().zip([square(speed) / 2.0, angle, squares]) {
                *seen += passes * (now - *seen);
            }
        }
        block.rise = seen[0] - before[0];
        block.turned = (seen[1] - before[1], seen[2] - before[2]);
    }
    Some((blocks, length as f64 * interval))
}

fn weight(deviation: f64) -> f64 {
    1.0 / square(deviation)
}

fn square(x: f64) -> f64 {
    x * x
}
