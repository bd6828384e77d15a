//! A rotor that turns by a script, and the lines of correctly wired hall sensors on it.

use narx_core::motor::sense::samples::EDGES_MAX;
use narx_core::motor::{Edge, EdgeSource, Samples};

/// Hall code at an angle in turns: A is high from 330 to 150 degrees, B and C 120 degrees later.
pub(crate) fn code_at(turns: f64) -> u8 {
    (0..3).fold(0, |code, phase| {
        let x = (turns + 30.0 / 360.0 - phase as f64 / 3.0).rem_euclid(1.0);
        code | u8::from(x < 0.5) << phase
    })
}

/// Sector at an angle in turns: sector s spans 30 + 60 s to 90 + 60 s degrees.
pub(crate) fn sector_at(turns: f64) -> u8 {
    ((turns - 1.0 / 12.0).rem_euclid(1.0) * 6.0) as u8 % 6
}

/// Signed distance in degrees of a u32 turn from an angle in turns.
pub(crate) fn error_degrees(angle: u32, turns: f64) -> f64 {
    let difference = angle as f64 / 4_294_967_296.0 - turns;
    ((difference + 0.5).rem_euclid(1.0) - 0.5) * 360.0
}

/// A scripted rotor: its speed is constant between calls; the script may change it.
#[derive(Clone, Debug)]
pub(crate) struct ScriptedRotor {
    /// Electrical angle at the boundary at the start of the present period, turns.
    pub angle: f64,
    /// Speed, turns per tick.
    pub speed: f64,
    /// Instant of the period at which the level is sampled, share of it.
    pub sample_at: f64,
    /// Edges have time stamps.
    pub capture: bool,
}

impl ScriptedRotor {
    /// A rotor with `frequency` in electrical revolutions per second, at 10 000 ticks per second.
    pub(crate) fn new(angle: f64, frequency: f64, capture: bool) -> Self {
        Self { angle, speed: frequency / 10_000.0, sample_at: 0.1, capture }
    }

    /// Goes on by one period: sets hall level and edges of the samples at the new boundary.
    pub(crate) fn advance(&mut self, samples: &mut Samples) {
        let before = self.angle;
        self.angle += self.speed;
        samples.hall = code_at(self.angle + self.speed * self.sample_at);
        samples.edges.clear();
        if !self.capture || self.speed == 0.0 {
            return;
        }
        // Boundaries lie at 1/12 + k/6 turns.
        let scaled = |turns: f64| (turns - 1.0 / 12.0) * 6.0;
        let (a, b) = (scaled(before), scaled(self.angle));
        let mut crossed: Vec<f64> = if b > a {
            (a.floor() as i64 + 1..=b.floor() as i64).map(|k| k as f64).collect()
        } else {
            (b.ceil() as i64..a.ceil() as i64).rev().map(|k| k as f64).collect()
        };
        crossed.truncate(EDGES_MAX);
        for k in crossed {
            let turns = k / 6.0 + 1.0 / 12.0;
            let instant = (turns - before) / self.speed;
            let code = code_at(turns + 1e-9 * self.speed.signum());
            let instant = (instant * 65_536.0).clamp(0.0, 65_535.0) as u16;
            let _ = samples.edges.push(Edge { instant, source: EdgeSource::Hall, code });
        }
    }
}
