//! Target of a sensor: a surface that the shaft moves.

use super::Shaft;
use core::f64::consts::TAU;

/// A surface and how it moves. Its distance from the start of the measuring range is the sum of what stands
/// here.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// At angle 0 and standstill, without run-out, mm.
    pub rest: f64,
    /// Run-out, which repeats with every revolution.
    pub run_out: [Harmonic; 2],
    /// The shaft's way along itself.
    pub play: AxialPlay,
    /// Way of a nut on a screw, mm per revolution; 0 without a screw.
    pub lead: f64,
}

/// amplitude cos(order angle + phase).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmonic {
    /// Periods of a revolution.
    pub order: u8,
    /// Half of peak to peak, mm.
    pub amplitude: f64,
    /// Degrees of its own period.
    pub phase_deg: f64,
}

/// Play of the bearings. The magnets centre the rotor with a force that grows with the way; what it drives (a
/// fan, a pump) pushes with one that grows with the speed's square, and the other way round in reverse.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxialPlay {
    /// From end to end, mm.
    pub length: f64,
    /// Speed at which the thrust has pushed it to its end, rad/s; 0: any speed does.
    pub end_speed: f64,
}

impl Target {
    /// The shaft's own surface, seen by a sensor at `bearing_deg` around it: bent by 20 um and oval by 5 um.
    pub fn surface(rest: f64, bearing_deg: f64) -> Self {
        let seen =
            |order: u8, amplitude| Harmonic { order, amplitude, phase_deg: -f64::from(order) * bearing_deg };
        Self { run_out: [seen(1, 0.020), seen(2, 0.005)], ..Self::still(rest) }
    }

    /// A disc on the shaft's end, seen along the shaft: it wobbles by 8 um, and its bearings have 0.1 mm of
    /// play.
    pub fn face(rest: f64) -> Self {
        let wobble = Harmonic { order: 1, amplitude: 0.008, phase_deg: 0.0 };
        let play = AxialPlay { length: 0.1, end_speed: 400.0 };
        Self { run_out: [wobble, Harmonic::default()], play, ..Self::still(rest) }
    }

    /// A nut on a screw of `lead` mm per revolution.
    pub fn nut(rest: f64, lead: f64) -> Self {
        Self { lead, ..Self::still(rest) }
    }

    /// A surface that does not move.
    pub fn still(rest: f64) -> Self {
        Self { rest, run_out: [Harmonic::default(); 2], play: AxialPlay::default(), lead: 0.0 }
    }

    /// Distance from the start of the measuring range, mm.
    pub fn distance(&self, shaft: &Shaft) -> f64 {
        let turn = shaft.turns - libm::floor(shaft.turns);
        let run_out = self.run_out.iter().map(|harmonic| harmonic.at(turn));
        run_out.fold(self.rest + self.lead * shaft.turns + self.play.at(shaft.speed), |sum, part| sum + part)
    }
}

impl Harmonic {
    /// At a fraction of a revolution, mm.
    fn at(&self, turn: f64) -> f64 {
        if self.amplitude == 0.0 {
            return 0.0;
        }
        self.amplitude * libm::cos(TAU * (f64::from(self.order) * turn + self.phase_deg / 360.0))
    }
}

impl AxialPlay {
    /// From the middle of the play, mm.
    fn at(&self, speed: f64) -> f64 {
        if self.length == 0.0 || speed == 0.0 {
            return 0.0;
        }
        let thrust = speed.abs() / self.end_speed.abs().max(f64::MIN_POSITIVE);
        // way / (length / 2) = (speed / end_speed)^2, up to the end.
        0.5 * self.length * (thrust * thrust).min(1.0) * 1.0_f64.copysign(speed)
    }
}
