//! Counts the instructions of other people's control on the Cortex-M4F, under `-icount shift=7`, as
//! `firmware/gauges/count.rs` counts ours.
//!
//! Prints `other NAME TICKS TOTAL WORST`, what they were fed with behind `#`, or `error NAME WHY` where an
//! answer is not what it should be:
//!
//! - `foc-space-vector`, `foc-trapezoidal`: a call of `foc::Foc::update`, that is sine and cosine, Clarke,
//!   Park, two PIs, back, and a modulator. Angle and currents come ready; nothing is measured, limited,
//!   protected or started.
//! - `pid-f32`: a step of `pid::Pid` on the processor's floating point, and `narx-pi`, the PI of our blocks,
//!   with the same gains.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    narx_firmware::boards::qemu::semihosting::exit(image::run().is_some())
}

#[cfg(target_os = "none")]
mod image {
    use core::f64::consts::TAU;
    use core::hint::black_box;
    use cortex_m_semihosting::hprintln;
    use fixed::types::I16F16;
    use foc::Foc;
    use foc::pid::PIController;
    use foc::pwm::{Modulation, SpaceVector, Trapezoidal};
    use narx_core::blocks::{Pi, PiSettings};
    use narx_core::motor::gain::Gain;
    use narx_firmware::boards::qemu::instructions::{self, Sum};

    /// 2 s of the motor of the rows `running`: 1656 rpm, 8 pole pairs.
    const TICKS: u32 = 20_000;
    const TURNS_A_TICK: f64 = 220.8e-4;
    /// Counts of the PWM timer.
    const RESOLUTION: u16 = 1_000;

    /// `None` if something did not do its work.
    pub(crate) fn run() -> Option<()> {
        let mut peripherals = cortex_m::Peripherals::take()?;
        let bracket = instructions::start(&mut peripherals.SYST);
        let results = [
            foc::<SpaceVector>("foc-space-vector", bracket),
            foc::<Trapezoidal>("foc-trapezoidal", bracket),
            pid(bracket),
            narx_pi(bracket),
        ];
        results.into_iter().collect()
    }

    /// The whole controller. The rotor turns, 1 A flows in its quadrature axis, and 2 A are asked for: with a
    /// gain of 0.8 the voltage has to stand a quarter of a turn before the rotor, wherever that is. The
    /// integrators' gain is 0: of an error that nothing mends their rounding would drift away.
    fn foc<M: Modulation>(name: &str, bracket: u32) -> Option<()> {
        // Release 0.3.0 takes the error as measurement less set-point.
        let pi = || PIController::new(I16F16::from_num(-0.8), I16F16::ZERO);
        let mut controller: Foc<M, RESOLUTION> = Foc::new(pi(), pi());
        let (mut sum, mut direct, mut quadrature) = (Sum::default(), 0.0, 0.0);
        for tick in 0..TICKS {
            let turns = f64::from(tick) * TURNS_A_TICK;
            let angle = (turns - libm::floor(turns)) * TAU;
            let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
            let currents = [-sine, -libm::sin(angle - TAU / 3.0)].map(I16F16::from_num);
            // Its sine takes angles of up to half a turn either way.
            let wrapped = if angle > TAU / 2.0 { angle - TAU } else { angle };
            let (angle, wanted, dt) =
                (I16F16::from_num(wrapped), I16F16::from_num(2), I16F16::from_num(1e-4));
            let inputs = black_box((currents, angle, wanted, dt));
            let (duties, spent) =
                instructions::count(|| black_box(controller.update(inputs.0, inputs.1, inputs.2, inputs.3)));
            sum.add(spent.saturating_sub(bracket));
            let [a, b, c] = duties.map(|duty| 2.0 * f64::from(duty) / f64::from(RESOLUTION) - 1.0);
            let (alpha, beta) = ((2.0 * a - b - c) / 3.0, (b - c) / 1.732_050_807_568_877);
            direct += alpha * cosine + beta * sine;
            quadrature += beta * cosine - alpha * sine;
        }
        let (direct, quadrature) = (direct / f64::from(TICKS), quadrature / f64::from(TICKS));
        hprintln!("other {} {}", name, sum);
        hprintln!("# {}: voltage {:.3} along the rotor, {:.3} across it", name, direct, quadrature);
        let across = quadrature > 0.8 && libm::fabs(direct) < 0.02;
        check(name, across, "the voltage does not go with the rotor")
    }

    /// A set-point of 100 and a plant that follows the output by a hundredth a tick: both controllers have to
    /// arrive there.
    const SET_POINT: i32 = 100_000;
    const MOST: i32 = 200_000;

    fn pid(bracket: u32) -> Option<()> {
        let mut controller = pid::Pid::<f32>::new(SET_POINT as f32, MOST as f32);
        controller.p(0.5, MOST as f32).i(0.01, MOST as f32);
        follow("pid-f32", bracket, |measured| controller.next_control_output(measured as f32).output as i32)
    }

    fn narx_pi(bracket: u32) -> Option<()> {
        let settings = PiSettings {
            proportional: Gain::from_ratio(1, 2)?,
            integral: Gain::from_ratio(1, 100)?,
            step_rate: 1,
            minimum: -MOST,
            maximum: MOST,
        };
        let mut controller = Pi::build(&settings).ok()?;
        follow("narx-pi", bracket, |measured| controller.step(SET_POINT - measured))
    }

    fn follow(name: &str, bracket: u32, mut step: impl FnMut(i32) -> i32) -> Option<()> {
        let (mut sum, mut measured) = (Sum::default(), 0);
        for _ in 0..TICKS {
            let input = black_box(measured);
            let (output, spent) = instructions::count(|| black_box(step(input)));
            sum.add(spent.saturating_sub(bracket));
            measured += (output - measured) / 100;
        }
        hprintln!("other {} {}", name, sum);
        hprintln!("# {}: {} of {} at the end", name, measured, SET_POINT);
        check(name, (measured - SET_POINT).abs() < SET_POINT / 50, "the set-point is not reached")
    }

    fn check(name: &str, holds: bool, why: &str) -> Option<()> {
        if !holds {
            hprintln!("error {} {}", name, why);
        }
        holds.then_some(())
    }
}
