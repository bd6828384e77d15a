//! When a settled loop keeps to its lane, and when it has none.

use crate::scripted::{bus_code, current_code};
use crate::support::coefficients;
use narx_core::motor::band::Band;
use narx_core::motor::control::{Control, ControlCoefficients, Demand, Lane};
use narx_core::motor::event::Limiter;
use narx_core::motor::measurement::Measurement;
use narx_core::motor::{Coefficients, Samples};
use narx_core::units::Amps;

const BUS: i32 = 24 << 16;

/// A hall drive's loops on 24 V without a load, whose current limiter waits exactly where the speed loop is as soon as the duty is there.
struct Loops {
    c: Coefficients,
    control: Control,
    measurement: Measurement,
    current: Amps,
}

const EVERYTHING: Band = Band::new(-(1 << 30), 1 << 30);
const ANYWHERE: Lane = Lane { voltage: EVERYTHING, current: EVERYTHING, duty: EVERYTHING };
/// Electrical rev/s.
const SPEED: i32 = 100 << 16;

impl Loops {
    fn new(c: Coefficients) -> Self {
        let mut measurement = Measurement::default();
        let samples =
            Samples { bus_voltage: bus_code(24.0), bus_current: current_code(0.0), ..Samples::default() };
        let current = measurement.step(&c.measurement, &samples);
        let mut control = Control::default();
        control.start(&c.control, 0, 0);
        Self { c, control, measurement, current }
    }

    /// Goes on from `voltage` for so many ticks.
    fn hold(&mut self, voltage: i32, ticks: u32) {
        self.control.hand_over(SPEED, voltage);
        self.run(ticks);
    }

    fn run(&mut self, ticks: u32) {
        let demand = Demand::Speed { measured: SPEED, fade: 0 };
        let measured = self.measurement.measured(self.current);
        for _ in 0..ticks {
            self.control.step(&self.c.control, &self.c.hall_mode, demand, &measured, &self.measurement);
        }
    }

    fn lane(&self) -> Lane {
        self.control.lane(&self.c.control, &ANYWHERE, self.measurement.bus_voltage())
    }

    /// One turn of the speed loop at another speed.
    fn turn(&mut self, speed: i32) {
        let bus = (self.measurement.bus_voltage(), self.current.to_bits());
        self.control.turn(&self.c.control, &self.c.hall_mode, (SPEED, self.c.control.speed_rate), speed, bus);
    }
}

/// A turn of the speed loop leaves a lane as it is, or shows that it is over: at no voltage there is no duty.
#[test]
fn a_lane_is_kept_as_long_as_its_duties_can_be_found() {
    let settled = || {
        let mut loops = Loops::new(coefficients(&[]));
        // Once more when the duty is there: on its way up the speed loop has followed it.
        loops.hold(BUS / 4, 500);
        loops.hold(BUS / 4, 2);
        assert!(!loops.lane().duty.is_empty() && loops.control.keeps(&loops.lane()));
        loops
    };
    for (speed, keeps, voltages) in
        [(SPEED, true, 1..BUS / 3), (SPEED + (1 << 16), true, 1..BUS / 3), (30_000 << 16, false, 0..1)]
    {
        let mut loops = settled();
        let lane = loops.lane();
        loops.turn(speed);
        let voltage = loops.control.speed_voltage();
        assert!(voltages.contains(&voltage), "{speed}: {voltage}");
        assert_eq!(loops.control.keeps(&lane), keeps, "{speed}: {voltage}");
        let (c, mut short) = (loops.c.control, loops.control);
        let duties = c.duties(loops.c.hall_mode.duty_max);
        assert_eq!(short.cruise(&c, duties, loops.current, &loops.measurement).is_some(), keeps, "{speed}");
    }
}

/// A duty that is as far up as its slew lets it go, to the last digit: the current limiter still waits a little below the speed loop, so this tick's
/// loop is not settled, and the next one's is.
#[test]
fn a_loop_settles_where_its_limiter_waits() {
    let c = coefficients(&[]);
    let slew = 8 * c.control.duty_min;
    let c = Coefficients { control: ControlCoefficients { slew, dead_time: 0, ..c.control }, ..c };
    let mut loops = Loops::new(c);
    // The most that this duty stands for.
    let voltage = (1..BUS).take_while(|voltage| loops.measurement.duty(*voltage).to_bits() <= slew).last();
    loops.hold(voltage.unwrap(), 1);
    let output = loops.control.output();
    assert_eq!((output.duty.to_bits(), output.limiter), (slew, Limiter::Speed));
    assert_eq!(loops.lane(), Lane::default());
    loops.run(1);
    assert_eq!(loops.control.output(), output);
    assert_ne!(loops.lane(), Lane::default());
}

/// Only a loop that has settled has a lane, and it begins around the last duty.
#[test]
fn a_loop_that_has_not_settled_has_no_lane() {
    let c = coefficients(&[]).control;
    let control = Control::default();
    assert_eq!(control.lane(&c, &ANYWHERE, BUS), Lane::default());
    assert!(!control.keeps(&ANYWHERE));
}
