//! Three hall sensors, their wiring and what can break in it.

use super::angle::fraction;
use super::config::HallConfig;
use super::injection::Injected;
use crate::random::Random;
use heapless::Vec;
use narx_core::motor::sense::samples::EDGES_MAX;
use narx_core::motor::{Edge, EdgeSource};

/// Length of a glitch, 1/65 536 of a period.
const GLITCH: u32 = 1311;

/// One sensor switches at two places half a turn apart.
#[derive(Clone, Copy, Debug, Default)]
struct Sensor {
    /// Its rising edge, turns.
    rises_at: f64,
    /// Half turns since `rises_at`, whole: even is high.
    half_turns: f64,
    /// The output stays between these angles, turns.
    below: f64,
    above: f64,
}

/// The sensors and the lines that the drive sees.
#[derive(Clone, Debug)]
pub(crate) struct Halls {
    sensors: [Sensor; 3],
    order: [usize; 3],
    polarity: u8,
    jitter: f64,
    hysteresis: f64,
    glitch_rate: f64,
    /// A glitch of this period: line mask, start and end in 1/65 536.
    glitch: Option<(u8, u32, u32)>,
    /// The lines without glitch.
    steady: u8,
    /// The lines.
    code: u8,
    /// No sensor switches while the rotor stays between these angles, turns.
    quiet: (f64, f64),
}

/// Time-stamped edges of one period.
#[derive(Clone, Debug, Default)]
pub(crate) struct Capture {
    pub(crate) edges: Vec<Edge, EDGES_MAX>,
    pub(crate) lost: u8,
}

impl Capture {
    pub(crate) fn push(&mut self, instant: u16, source: EdgeSource, code: u8) {
        if self.edges.push(Edge { instant, source, code }).is_err() {
            self.lost = self.lost.saturating_add(1);
        }
    }
}

impl Halls {
    pub(crate) fn new(config: &HallConfig, angle: f64) -> Self {
        let mut halls = Self {
            sensors: [Sensor::default(); 3],
            order: HallConfig::ORDERS[usize::from(config.order) % HallConfig::ORDERS.len()],
            polarity: config.polarity & 7,
            jitter: config.jitter_deg / 360.0,
            hysteresis: config.hysteresis_deg / 360.0,
            glitch_rate: config.glitch_rate,
            glitch: None,
            steady: 0,
            code: 0,
            quiet: (0.0, 0.0),
        };
        for (index, sensor) in halls.sensors.iter_mut().enumerate() {
            sensor.rises_at = -30.0 / 360.0
                + index as f64 * (1.0 / 3.0)
                + (config.offset_deg + config.placement_deg[index]) / 360.0;
            let x = 2.0 * (angle - sensor.rises_at);
            sensor.half_turns = x - fraction(x);
            sensor.set_bounds(halls.hysteresis, 0.0, 0.0);
        }
        halls.find_quiet();
        halls.settle(&Injected::default());
        halls
    }

    /// The three lines: bit 0 = A, bit 1 = B, bit 2 = C.
    pub(crate) fn code(&self) -> u8 {
        self.code
    }

    /// Lines as wired, after injected faults, without glitches.
    fn lines(&self, injected: &Injected) -> u8 {
        if injected.hall_supply_lost || injected.hall_supply_off {
            return 7;
        }
        let mut lines = 0;
        for (line, &sensor) in self.order.iter().enumerate() {
            if self.sensors[sensor % 3].is_high() {
                lines |= 1 << line;
            }
        }
        lines ^= self.polarity;
        if let Some(first) = injected.hall_swapped {
            let (a, b) = (first.index(), (first.index() + 1) % 3);
            let differ = ((lines >> a) ^ (lines >> b)) & 1;
            lines ^= differ << a | differ << b;
        }
        for (line, stuck) in injected.hall_stuck.iter().enumerate() {
            match stuck {
                Some(true) => lines |= 1 << line,
                Some(false) => lines &= !(1 << line),
                None => {}
            }
        }
        lines
    }

    /// Takes over the lines without noticing edges: at the start.
    fn settle(&mut self, injected: &Injected) {
        self.steady = self.lines(injected);
        self.code = self.steady;
    }

    /// At the start of a period: may throw a glitch into it.
    pub(crate) fn start_period(&mut self, injected: &Injected, period: f64, random: &mut Random) {
        self.glitch = None;
        let rate = injected.hall_glitches.unwrap_or(self.glitch_rate);
        if rate > 0.0 && random.uniform() < rate * period {
            let bits = random.bits();
            let start = (bits >> 16) as u32 & 0xFFFF;
            self.glitch = Some((1 << ((bits >> 40) % 3), start, start + GLITCH));
        }
    }

    /// Nothing switches while the rotor comes to `angle`, turns.
    #[inline]
    pub(crate) fn are_quiet(&self, angle: f64) -> bool {
        angle > self.quiet.0 && angle < self.quiet.1 && self.glitch.is_none()
    }

    /// Follows the rotor from `angle_from` to `angle_to` (turns) in the part `from..to` (1/65 536) of the
    /// period, at constant speed, and captures the edges.
    pub(crate) fn follow(
        &mut self,
        angle: (f64, f64),
        part: (f64, f64),
        injected: &Injected,
        random: &mut Random,
        capture: &mut Capture,
    ) {
        // An edge a sensor; two sensors that switch at once are two edges.
        while let Some((place, index, step)) = self.next_crossing(angle.0, angle.1) {
            let reached = (place - angle.0) / (angle.1 - angle.0);
            let jitter = if self.jitter > 0.0 {
                (self.jitter * random.gaussian(), self.jitter * random.gaussian())
            } else {
                (0.0, 0.0)
            };
            let sensor = &mut self.sensors[index];
            sensor.half_turns += step;
            sensor.set_bounds(self.hysteresis, jitter.0, jitter.1);
            // The edge just passed lies behind the rotor, wherever jitter would have it.
            if step > 0.0 {
                sensor.below = sensor.below.min(place);
            } else {
                sensor.above = sensor.above.max(place);
            }
            let at = part.0 + reached * (part.1 - part.0);
            self.play_glitch(at, capture);
            self.steady = self.lines(injected);
            self.show(at, capture);
        }
        self.find_quiet();
        self.play_glitch(part.1, capture);
    }

    fn find_quiet(&mut self) {
        let [a, b, c] = &self.sensors;
        self.quiet = (a.below.max(b.below).max(c.below), a.above.min(b.above).min(c.above));
    }

    /// Lets the lines show what has just been broken or mended, at `at` (1/65 536 of the period).
    pub(crate) fn rewire(&mut self, at: f64, injected: &Injected, capture: &mut Capture) {
        self.steady = self.lines(injected);
        self.show(at, capture);
    }

    /// The first place between two angles where a sensor switches: place, sensor, +1 or -1 half turns.
    fn next_crossing(&self, from: f64, to: f64) -> Option<(f64, usize, f64)> {
        let mut first: Option<(f64, usize, f64)> = None;
        for (index, sensor) in self.sensors.iter().enumerate() {
            let (place, step) = if to >= sensor.above && to > from {
                (sensor.above.max(from), 1.0)
            } else if to < sensor.below && to < from {
                (sensor.below.min(from), -1.0)
            } else {
                continue;
            };
            if first.is_none_or(|(earlier, ..)| (place - from).abs() < (earlier - from).abs()) {
                first = Some((place, index, step));
            }
        }
        first
    }

    /// Starts or ends the period's glitch if its time has come by `at`.
    fn play_glitch(&mut self, at: f64, capture: &mut Capture) {
        let Some((line, start, end)) = self.glitch else { return };
        let shown = self.code ^ self.steady;
        if shown & line == 0 && at >= f64::from(start) {
            self.code ^= line;
            capture.push(start as u16, EdgeSource::Hall, self.code);
        }
        if at >= f64::from(end.min(65_535)) {
            self.glitch = None;
            self.show(f64::from(end), capture);
        }
    }

    /// Lets the lines show their steady state, and the glitch while it lasts.
    fn show(&mut self, at: f64, capture: &mut Capture) {
        let glitch = match self.glitch {
            Some((line, start, end)) if at >= f64::from(start) && at < f64::from(end) => line,
            _ => 0,
        };
        let code = self.steady ^ glitch;
        if code != self.code {
            self.code = code;
            capture.push(at.clamp(0.0, 65_535.0) as u16, EdgeSource::Hall, code);
        }
    }
}

impl Sensor {
    fn is_high(&self) -> bool {
        (self.half_turns as i64) & 1 == 0
    }

    /// Sets the angles of the next output changes, behind and ahead.
    fn set_bounds(&mut self, hysteresis: f64, jitter_below: f64, jitter_above: f64) {
        let start = self.rises_at + 0.5 * self.half_turns;
        self.below = start - 0.5 * hysteresis + jitter_below;
        self.above = start + 0.5 + 0.5 * hysteresis + jitter_above;
    }
}
