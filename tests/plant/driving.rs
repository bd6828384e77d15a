//! Open-loop commutation from the rotor's true angle, as an ideal drive would do it.

use narx_core::motor::commutate::commutation::sector_of;
use narx_core::motor::{Commutation, Commutations, Direction, PwmCommand, Rectification, SampleMode, Step};
use narx_core::units::{Duty, ElectricalAngle};
use narx_sim::plant::{Observation, Plant};

/// An ideal drive.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ideal {
    /// Duty, 0..=1.
    pub(crate) duty: f64,
    /// Direction of rotation.
    pub(crate) direction: Direction,
    /// Freewheeling.
    pub(crate) rectification: Rectification,
}

impl Ideal {
    /// A drive forward at `duty`.
    pub(crate) fn forward(duty: f64) -> Self {
        Self { duty, direction: Direction::Forward, rectification: Rectification::Synchronous }
    }

    /// Command for one period with `step`, the same duty and no commutation.
    pub(crate) fn hold(&self, step: Step) -> PwmCommand {
        PwmCommand {
            duty: Duty::from_bits((self.duty * 32_768.0) as u16),
            rectification: self.rectification,
            sample_at: 1000,
            sample_mode: SampleMode::OnTime,
            step,
            commutations: Commutations::default(),
        }
    }

    /// Command for the rest of this period and the beginning of the next, until the next command can act.
    pub(crate) fn command(&self, seen: &Observation, plant: &Plant) -> PwmCommand {
        let board = plant.config().board;
        let period = 1.0 / f64::from(board.tick_rate);
        let turns_per_period =
            seen.speed * f64::from(plant.config().motor.pole_pairs) / std::f64::consts::TAU * period;
        let now = (seen.time / period).fract();
        let angle_at = |part: f64| seen.electrical_turns + turns_per_period * (part - now);
        let earliest = f64::from(board.earliest) / 65_536.0;
        let sector = sector_at(angle_at(earliest.max(now)));
        let mut command = self.hold(Step::for_sector(sector, self.direction));
        // Sector boundaries lie at 30 + 60 s degrees: 1/12 + s/6 of a turn.
        let mut last = sector;
        for part in 1..=65_535u32 / 64 {
            let instant = part * 64;
            let now_in = sector_at(angle_at(f64::from(instant) / 65_536.0));
            if now_in != last && f64::from(instant) / 65_536.0 > earliest {
                command.commutations.push(Commutation {
                    instant: instant as u16,
                    step: Step::for_sector(now_in, self.direction),
                });
                last = now_in;
            }
        }
        command
    }

    /// Runs for `seconds`.
    pub(crate) fn run(&self, plant: &mut Plant, seconds: f64) {
        let ticks = (seconds * f64::from(plant.config().board.tick_rate)).round() as u64;
        for _ in 0..ticks {
            plant.sample();
            let command = self.command(&plant.observe(), plant);
            plant.finish_period(&command);
        }
    }
}

/// Sector of an angle in turns.
pub(crate) fn sector_at(turns: f64) -> u8 {
    sector_of(ElectricalAngle((turns.rem_euclid(1.0) * 65_536.0) as u16))
}
