//! Inertia, from the power that accelerates the rotor.
//!
//! The power of the bus, less the heat of the winding, becomes kinetic energy and friction:
//!
//! ```text
//!  V I - R i^2 = w (J dw/dt + J (c + b w))
//! ```
//!
//! with the current `i = I / D` of the phases, and the friction `c + b w` over inertia of the coasting rotor.
//! Integrated over the acceleration it needs no derivative.

use super::coast::Coast;
use super::record::Record;
use super::winding::Winding;
use core::f64::consts::TAU;
use libm::{fabs, fmax};

/// Shares of the rise in speed between which the power counts.
const FROM: f64 = 0.15;
const TO: f64 = 0.85;
/// Rows at each end that tell the speed before and after.
const ENDS: usize = 24;
/// Least rise of the speed, as a share of the speed at its end.
const LEAST: f64 = 0.2;

/// The filter of the bus current shows it so much later, s.
const FILTER: f64 = 6.4e-3;

/// Relative uncertainty of the inertia at best.
const FLOOR: f64 = 0.05;
/// Error that is left of the current channel's zero, A.
const ZERO: f64 = 1e-3;

/// Inertia, kg m2, with its relative uncertainty, and the torque constant as the driven motor shows it,
/// V s/rad: `(V D - R i) / w` at the end of the record. It is high by what commutation drops.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inertia {
    pub(super) value: f64,
    pub(super) uncertainty: f64,
    pub(super) torque_constant: f64,
}

/// Inertia of a record of speed, bus voltage, bus current and duty, kg m2;
/// `None` if the speed hardly rises. zero: what the current channel reads without a current, A. pole_pairs,
/// and the PWM period in s.
pub(super) fn inertia(
    record: &Record,
    winding: &Winding,
    coast: &Coast,
    zero: f64,
    pole_pairs: f64,
    period: f64,
) -> Option<Inertia> {
    let rows = || record.rows::<4>().map(|[speed, ..]| fabs(speed) * TAU / 60.0);
    let mean = |rows: &mut dyn Iterator<Item = f64>| rows.sum::<f64>() / ENDS as f64;
    let begin = mean(&mut rows().take(ENDS));
    let end = mean(&mut rows().rev().take(ENDS));
    let rise = end - begin;
    if end.is_nan() || rise < LEAST * end {
        return None;
    }
    let first = rows().position(|speed| speed > begin + FROM * rise)?;
    let last = rows().position(|speed| speed > begin + TO * rise)?;
    let (mut energy, mut lost, mut friction, mut unsure) = (0.0, 0.0, 0.0, 0.0);
    let (c, b) = (coast.friction.0 / pole_pairs, coast.friction.1);
    let late = libm::round(FILTER / record.interval) as usize;
    let currents = record.rows::<4>().map(|[_, _, current, _]| current).skip(first + late);
    let driven = record.rows::<4>().skip(first).take(last.checked_sub(first)?);
    for ([rpm, voltage, _, duty], current) in driven.zip(currents) {
        let speed = fabs(rpm) * TAU / 60.0;
        let duty = fmax(duty / 100.0 - winding.lost, 0.01);
        let current = current - zero;
        let phase = current / duty;
        let ripple = voltage * duty * (1.0 - duty) * period / winding.inductance;
        let heat = winding.resistance * (phase * phase + ripple * ripple / 12.0);
        energy += voltage * current * record.interval;
        unsure += voltage * ZERO * record.interval;
        lost += heat * record.interval;
        friction += (c + b * speed) * speed * record.interval;
    }
    let at = |row: usize| rows().nth(row);
    let (slow, fast) = (at(first)?, at(last)?);
    let kinetic = (fast * fast - slow * slow) / 2.0;
    let value = (energy - lost) / (kinetic + friction);
    // The heat is known to a fifth, with what commutation adds, and friction as the coasting rotor shows it.
    let off = FLOOR + (0.2 * lost + unsure) / fmax(energy - lost, 1e-9);
    let uncertainty = off + coast.error * friction / (kinetic + friction);
    let (mut back_emf, mut turned) = (0.0, 0.0);
    for [rpm, voltage, current, duty] in record.rows::<4>().rev().take(ENDS) {
        let duty = fmax(duty / 100.0 - winding.lost, 0.01);
        back_emf += voltage * duty - winding.resistance * (current - zero) / duty;
        turned += fabs(rpm) * TAU / 60.0;
    }
    let torque_constant = back_emf / turned;
    (value.is_finite() && value > 0.0).then_some(Inertia { value, uncertainty, torque_constant })
}
