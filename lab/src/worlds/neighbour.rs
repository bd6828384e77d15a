//! A second drive on the bus of a world. Nothing happens to it but what happens to the bus, to the operator
//! and to the supply: it starts and stops, and every invariant holds for it, too.

use super::mishap::Fate;
use super::never::{Checked, Watch};
use super::world::{Setting, master};
use narx_core::bus::Frame;
use narx_core::bus::narmotion::MotorMode;
use narx_core::commissioning::{Commissioning, Mode};
use narx_core::dictionary::{Access, Parameters, number};
use narx_core::master::Master;
use narx_core::motor::{State, Status};
use narx_sim::bench::Bench;
use narx_sim::can::Received;
use narx_sim::plant::PlantConfig;
use narx_sim::presets::PRESETS;
use narx_sim::random::Random;
use std::f64::consts::TAU;

/// Share of the worlds that have two drives.
const SHARE: f64 = 0.25;
/// Address of its drive; the world's own has 170.
const ADDRESS: i32 = 171;
/// Time from one command of the operator to the next, s.
const PAUSE: (f64, f64) = (0.5, 5.0);
/// Longest time in peace until it turns as it was asked to, s: two faults that are acknowledged, and a start.
pub(super) const PEACE: f64 = 20.0;

/// The second drive with its operator.
pub(super) struct Neighbour {
    setting: Setting,
    fate: Fate,
    bench: Bench,
    master: Master,
    watch: Watch,
    /// Largest phase current so far, A.
    peak: f64,
    /// Tick of the next command.
    due: u64,
    ticks: u64,
    /// Time in which it has driven its motor, microseconds.
    driven: u64,
    /// Speed at which it has to turn once there are no more mishaps, rpm.
    peace: Option<f64>,
}

impl Neighbour {
    /// Draws whether this world has a second drive on the bus of `first`, and which motor it turns, with hall
    /// sensors and at its nominal voltage.
    pub(super) fn draw(seed: u64, first: &mut Bench, period: u64) -> Option<Self> {
        // Drawn apart from the world's own fate: worlds of one drive stay as they are.
        let mut fate = Fate(Random::new(!seed));
        if !fate.chance(SHARE) {
            return None;
        }
        let preset = &PRESETS[fate.below(PRESETS.len())];
        let supply = preset.data.nominal_voltage.clamp(20.0, 55.0);
        let mut setting = Setting::of(preset, Mode::Hall, supply, period, seed)?;
        setting.config.parameters.set(number::SLAVE_CAN_ADDRESS, ADDRESS).ok()?;
        let mut bench = Bench::new(&setting.config).without_recording();
        if !bench.move_beside(first) {
            return None;
        }
        Some(Self {
            master: master(&bench),
            watch: Watch::default(),
            due: 0,
            ticks: 0,
            driven: 0,
            peace: None,
            peak: 0.0,
            setting,
            fate,
            bench,
        })
    }

    /// Powers it up again, beside a first drive that has just been powered up: both have the same supply.
    pub(super) fn power_up(&mut self, first: &mut Bench) {
        let flash = std::mem::replace(&mut self.bench, Bench::new(&self.setting.config)).into_flash();
        self.bench = Bench::with_flash(&self.setting.config, flash).without_recording();
        // There was a place for it on a bus of the same size.
        let _ = self.bench.move_beside(first);
        self.master = master(&self.bench);
        self.watch.begin_anew();
        (self.ticks, self.due) = (0, 0);
    }

    /// Runs a tick; the operator's frames go to the bus unless he is `silent`.
    pub(super) fn tick(&mut self, first: &mut Bench, silent: bool) -> Checked {
        self.ticks += 1;
        if self.ticks >= self.due {
            self.command();
        }
        self.send(first, silent);
        self.bench.step_beside(first);
        self.driven += if self.bench.status().state.is_driving() { self.setting.period } else { 0 };
        self.watch.tick(&self.bench, self.setting.period)?;
        self.peak = self.peak.max(self.bench.plant().observe().peak_current);
        let PlantConfig { motor, inverter, .. } = &self.setting.config.plant;
        let stored = 0.5 * motor.inductance * self.peak * self.peak;
        Watch::physics(&self.bench, stored, inverter.capacitance)
    }

    /// The next command: a start, another speed, or Standby, which acknowledges a fault.
    fn command(&mut self) {
        let (rpm, pause) = match self.peace {
            Some(rpm) => (rpm, PAUSE.0),
            None => {
                let Commissioning { speed_min, speed_max, .. } = self.setting.commissioning;
                let rpm = self.fate.between(speed_min, speed_max);
                let sign = if self.fate.chance(0.5) { 1.0 } else { -1.0 };
                (sign * rpm, self.fate.between(PAUSE.0, PAUSE.1))
            }
        };
        self.due = self.ticks + (pause * 1e6) as u64 / self.setting.period;
        // A start needs a request for Standby before it.
        let is_ready = self.master.requested() == Some(MotorMode::Standby);
        match self.bench.status().state {
            State::Standby if is_ready => self.master.start(rpm as i32),
            state if state.is_driving() && (self.peace.is_some() || self.fate.chance(0.5)) => {
                self.master.set_speed(rpm.abs() as u16);
            }
            _ => self.master.stop(),
        }
    }

    /// There are no more mishaps: from now on it is asked to turn forward at a speed in the middle.
    pub(super) fn make_peace(&mut self) {
        let Commissioning { speed_min, speed_max, .. } = self.setting.commissioning;
        let middle = 0.5 * (speed_min + speed_max);
        self.master.stop();
        (self.peace, self.due) = (Some(middle), 0);
    }

    /// Returns whether it turns as it was asked to in peace.
    pub(super) fn turns(&self) -> bool {
        let rpm = self.bench.plant().observe().speed * 60.0 / TAU;
        self.peace.is_some_and(|asked| (rpm / asked - 1.0).abs() < 0.05)
    }

    /// Time in which it has driven its motor, microseconds.
    pub(super) const fn driven(&self) -> u64 {
        self.driven
    }

    /// State of the drive, for people.
    pub(super) fn status(&self) -> &Status {
        self.bench.status()
    }

    fn send(&mut self, first: &mut Bench, silent: bool) {
        let now = self.bench.now_ns() / 1000;
        while !silent && let Some(frame) = self.master.poll_frame(now) {
            // The frames of a master whose cable is disconnected are refused.
            let _ = first.send(frame);
        }
    }

    /// Takes a frame that has arrived at the host.
    pub(super) fn receive(&mut self, frame: &Frame) {
        self.master.handle_frame(frame, self.bench.now_ns() / 1000);
    }

    /// Checks a frame on the bus, if this drive has sent it. A stray frame may have its address.
    pub(super) fn check(&self, received: &Received) -> Checked {
        if received.sender != self.bench.own() {
            return Ok(());
        }
        Watch::frame(&received.frame, self.bench.node().addresses().drive)
    }

    /// Returns whether somebody has written one of its parameters: then it need not turn.
    pub(super) fn is_changed(&self) -> bool {
        let now: &Parameters = self.bench.node().parameters();
        let commissioned = &self.setting.config.parameters;
        commissioned
            .iter()
            .any(|(row, raw)| row.access != Access::ReadOnly && !row.command && now.raw(row.number) != raw)
    }
}
