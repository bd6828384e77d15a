//! The plant with its gates in other hands: time and gates in, voltages, currents and hall lines out. A model
//! of a timer, of a whole chip or a program of the user's own closes the loop.

use super::config::{LoadConfig, PlantConfig, SupplyConfig};
use super::gates::Gate;
use super::hall::{Capture, Halls};
use super::injection::Injected;
use super::stage::Stage;
use super::{INSTANT, Phase};
use crate::random::Random;

/// Longest course of the shaft, s.
const COURSE: f64 = 50e-6;
/// Time between two corrections of what is followed in small steps, s.
const STRAIGHTEN: f64 = 10e-3;
/// An instant at which a shunt's current passes its limit is known to this, s.
const LIMIT_STEP: f64 = 50e-9;
/// Parts of a stretch of time in which hall edges are captured.
const PARTS: f64 = 65_536.0;

/// A change of the hall lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HallEdge {
    /// s since the start.
    pub time: f64,
    /// Lines after it: bit 0 = A, bit 1 = B, bit 2 = C.
    pub code: u8,
}

/// Motor, load, bridge, bus, supply and hall sensors, whose gates the caller sets. Dead times are the
/// caller's, and neither converter nor comparators are in it. The winding stays at ambient temperature.
///
/// A switch that is on conducts both ways, one that is off leaves its diode.
#[derive(Clone, Debug)]
pub struct GatedPlant {
    time: f64,
    gates: [Gate; 3],
    stage: Stage,
    halls: Halls,
    followed: f64,
    capture: Capture,
    /// The stretch of time in which `capture` was filled, s.
    captured: (f64, f64),
    straightened: f64,
    injected: Injected,
    random: Random,
}

impl GatedPlant {
    /// At rest or at the configuration's speed, all switches off. Board, converter and comparators of the
    /// configuration are not used.
    pub fn new(config: &PlantConfig) -> Self {
        let mut stage = Stage::new(config);
        stage.network.leak_g = config.inverter.own_conductance;
        stage.set_supply(&config.supply);
        stage.set_temperature(&config.motor, config.ambient);
        Self {
            time: 0.0,
            gates: [Gate::Off; 3],
            stage,
            halls: Halls::new(&config.hall, config.angle_deg / 360.0),
            followed: config.angle_deg / 360.0,
            capture: Capture::default(),
            captured: (0.0, 0.0),
            straightened: 0.0,
            injected: Injected::default(),
            random: Random::new(config.seed),
        }
    }

    /// Sets the gates of legs A, B and C from now on.
    pub fn set_gates(&mut self, gates: [Gate; 3]) {
        if gates != self.gates {
            self.gates = gates;
            self.stage.arrive();
            self.stage.set_gates(&gates);
        }
    }

    /// Advances by at most `seconds`; ends early after a change of the hall lines, and where the current of a
    /// shunt passes `limit`, A, upwards. Returns by how much, s.
    pub fn advance(&mut self, seconds: f64, limit: Option<f64>) -> f64 {
        self.capture = Capture::default();
        let start = self.time;
        let end = start + seconds;
        while end - self.time > INSTANT && self.capture.edges.is_empty() {
            if self.time - self.straightened > STRAIGHTEN {
                self.straightened = self.time;
                self.stage.straighten();
            }
            if self.stage.course.is_done() {
                self.stage.set_out(COURSE, 0.0);
            }
            let rest = (end - self.time).min(self.stage.course.rest());
            let (step, passes) = match limit {
                Some(limit) => self.step_to(rest, limit),
                None => (rest, false),
            };
            let from = self.time;
            let mut left = step;
            while left > INSTANT {
                let passed = self.stage.interval(left);
                left = if passed >= left { 0.0 } else { left - passed };
            }
            self.time = if end - from - step < INSTANT { end } else { from + step };
            if self.stage.course.is_done() {
                self.stage.arrive();
            } else {
                self.stage.go_on();
            }
            self.follow_halls(from);
            if passes && limit.is_some_and(|limit| self.shunts().into_iter().any(|current| current >= limit))
            {
                break;
            }
        }
        self.time - start
    }

    /// A step of `rest` seconds or less in which no shunt's current can go beyond `limit`, and whether one
    /// may reach it.
    fn step_to(&self, rest: f64, limit: f64) -> (f64, bool) {
        let most = self.shunts().into_iter().fold(f64::MIN, f64::max);
        if most >= limit {
            return (rest, false);
        }
        // All that may drive a current: bus, the largest line-to-line back-EMF, two drops.
        let (stage, network) = (&self.stage, &self.stage.network);
        let volts = stage.electric.v + stage.shape.line_peak() * stage.speed().abs() + 2.0 * network.drop;
        let sure = (limit - most.max(0.0)) / (volts * network.per_l);
        let step = sure.max(LIMIT_STEP);
        if step < rest { (step, true) } else { (rest, true) }
    }

    fn follow_halls(&mut self, from: f64) {
        let angle = self.stage.angle();
        let before = core::mem::replace(&mut self.followed, angle);
        if !self.halls.are_quiet(angle) {
            self.captured = (from, self.time);
            self.halls.follow(
                (before, angle),
                (0.0, PARTS),
                &self.injected,
                &mut self.random,
                &mut self.capture,
            );
        }
    }

    /// Changes of the hall lines during the last [`advance`](Self::advance), in their order.
    pub fn hall_edges(&self) -> impl Iterator<Item = HallEdge> + '_ {
        let (from, to) = self.captured;
        let time = move |instant: u16| from + (to - from) * f64::from(instant) / PARTS;
        self.capture.edges.iter().map(move |edge| HallEdge { time: time(edge.instant), code: edge.code })
    }

    /// Time since the start, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The gates.
    pub fn gates(&self) -> [Gate; 3] {
        self.gates
    }

    /// Hall lines: bit 0 = A, bit 1 = B, bit 2 = C.
    pub fn hall(&self) -> u8 {
        self.halls.code()
    }

    /// Mechanical speed, rad/s.
    pub fn speed(&self) -> f64 {
        self.stage.speed()
    }

    /// Electrical angle, turns, unwrapped; 0 is the rising zero crossing of phase A's back-EMF.
    pub fn electrical_turns(&self) -> f64 {
        self.stage.angle()
    }

    /// Phase currents into the motor, A.
    pub fn currents(&self) -> [f64; 3] {
        self.stage.electric.i
    }

    /// Currents of the legs' shunts, A: positive from the phase to ground, 0 while the low side leads none.
    pub fn shunts(&self) -> [f64; 3] {
        const LOW: usize = 2;
        let stage = &self.stage;
        Phase::ALL.map(|leg| if stage.legs[leg].side() == LOW { -stage.electric.i[leg] } else { 0.0 })
    }

    /// Terminal voltages against ground, V.
    pub fn terminals(&self) -> [f64; 3] {
        self.stage.terminals()
    }

    /// Bus voltage, V.
    pub fn bus_voltage(&self) -> f64 {
        self.stage.electric.v
    }

    /// Charge that the bridge has taken from the bus since the start, A s.
    pub fn charge(&self) -> f64 {
        self.stage.charge()
    }

    /// Changes the load.
    pub fn set_load(&mut self, load: LoadConfig) {
        self.stage.set_load(load);
    }

    /// Changes the supply.
    pub fn set_supply(&mut self, supply: &SupplyConfig) {
        self.stage.arrive();
        self.stage.enter_book();
        self.stage.set_supply(supply);
    }

    /// Blocks or frees the rotor.
    pub fn set_blocked(&mut self, blocked: bool) {
        self.stage.arrive();
        self.stage.shaft.blocked = blocked;
    }

    /// Breaks or mends the cables of phases A, B and C.
    pub fn set_open(&mut self, open: [bool; 3]) {
        self.stage.arrive();
        self.stage.enter_book();
        self.stage.set_open(open);
        // A leg that is connected again goes on with its switch.
        self.stage.set_gates(&self.gates);
    }
}
