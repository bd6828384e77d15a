//! The check of a board against simulated boards: one that is as described, and one for each mistake that it
//! claims to find.

use narx_board::check::{BoardCheck, Check, Finding, Given, GivenError, pwm_rate};
use narx_core::motor::{Board, Channel, PwmCommand, Samples, Step};
use narx_core::units::{Amps, Duty, Volts};
use narx_sim::plant::{HallConfig, MotorConfig, Phase, Plant, PlantConfig};

const GIVEN: Given = Given {
    supply: Volts::from_milli(24_000),
    duty: Duty::from_bits(2_600),
    current_max: Amps::from_milli(3_000),
    motor: true,
};

/// A board with a mistake: what is wired otherwise than its description says.
struct Bench {
    described: Board,
    given: Given,
    plant: PlantConfig,
    /// Changes what the converter gives.
    samples: fn(&mut Samples),
    /// Changes which gates the timer drives.
    step: fn(Step) -> Step,
}

impl Default for Bench {
    fn default() -> Self {
        Self {
            described: Board::BENCH,
            given: GIVEN,
            plant: PlantConfig::new(MotorConfig::default(), 24.0),
            samples: |_| {},
            step: |step| step,
        }
    }
}

impl Bench {
    /// Runs the check to its end, 5 s at most.
    fn run(&self) -> Vec<Finding> {
        let mut check = BoardCheck::new(self.described, self.given).unwrap();
        let mut plant = Plant::new(&self.plant);
        for _ in 0..50_000 {
            let mut samples = plant.sample();
            (self.samples)(&mut samples);
            let command = check.step(&samples);
            plant.finish_period(&PwmCommand { step: (self.step)(command.step), ..command });
            if check.is_done() {
                // The last answer leaves all six switches off.
                assert_eq!(command.step, Step::Coast);
                return check.findings().copied().collect();
            }
        }
        panic!("no end: {:?}", check.findings().collect::<Vec<_>>());
    }

    /// The first finding that is wrong.
    fn mistake(&self) -> Finding {
        *self.run().iter().find(|finding| !finding.passes()).unwrap()
    }
}

/// Exchanges phases A and B of a step.
fn exchange(step: Step) -> Step {
    let [a, b, c] = step.legs();
    Step::ALL.into_iter().find(|other| other.legs() == [b, a, c]).unwrap()
}

#[test]
fn a_board_as_described_passes_every_check() {
    let findings = Bench::default().run();
    let shown: Vec<_> = findings.iter().map(ToString::to_string).collect();
    assert!(findings.iter().all(Finding::passes), "{shown:#?}");
    let names: Vec<_> = findings.iter().map(|finding| finding.check.name().0).collect();
    assert_eq!(
        names,
        [
            "current zero",
            "bus voltage",
            "phase order",
            "terminal voltage",
            "phase order",
            "terminal voltage",
            "phase order",
            "terminal voltage",
            "dead time",
            "current sign",
            "hall lines",
            "hall order",
            "hall polarity",
        ]
    );
}

#[test]
fn without_a_motor_the_bridge_alone_is_checked() {
    let given = Given { motor: false, ..GIVEN };
    let findings = Bench { given, ..Bench::default() }.run();
    assert!(findings.iter().all(Finding::passes), "{findings:?}");
    assert_eq!(findings.last().unwrap().check, Check::DeadTime);
}

#[test]
fn each_mistake_is_named() {
    let wrong = |channel: Channel, micro_per_code| Channel { micro_per_code, ..channel };
    let scaled = |change: fn(&mut Board)| {
        let mut described = Board::BENCH;
        change(&mut described);
        Bench { described, ..Bench::default() }
    };
    let sampled = |samples| Bench { samples, ..Bench::default() };

    // An amplifier without supply.
    let found = sampled(|samples| samples.bus_current = 0).mistake();
    assert_eq!((found.check, found.measured, found.expected), (Check::CurrentZero, 0, 2048));

    // A divider that is described 5 % too large.
    let mut board = Board::BENCH;
    board.front_end.bus_voltage = wrong(board.front_end.bus_voltage, 20_508);
    let found = Bench { described: board, ..Bench::default() }.mistake();
    assert_eq!(found.check, Check::BusVoltage);
    assert!((25_100..25_300).contains(&found.measured), "{found}");

    // Likewise the terminals.
    let mut board = Board::BENCH;
    board.front_end.phase_voltage = wrong(board.front_end.phase_voltage, 20_508);
    let found = Bench { described: board, ..Bench::default() }.mistake();
    assert_eq!((found.check, found.phase), (Check::TerminalVoltage, Some(0)));

    // Legs A and B exchanged, or the converter's channels B and C.
    let found = Bench { step: exchange, ..Bench::default() }.mistake();
    assert_eq!((found.check, found.phase, found.measured), (Check::PhaseOrder, Some(0), 1));
    let found = sampled(|samples| samples.phase_voltage.swap(1, 2)).mistake();
    assert_eq!((found.check, found.phase, found.measured), (Check::PhaseOrder, Some(1), 2));

    // A driver that is not enabled.
    let found = Bench { step: |_| Step::Coast, ..Bench::default() }.mistake();
    assert_eq!((found.check, found.phase, found.measured), (Check::PhaseOrder, Some(0), -1));

    // A dead time of 500 ns that is described as 1 us.
    let found = scaled(|board| board.dead_time_ns = 1_000).mistake();
    assert_eq!((found.check, found.expected), (Check::DeadTime, 1_000));
    assert!((400..700).contains(&found.measured), "{found}");

    // A shunt's amplifier that is connected the wrong way round.
    let found = sampled(|samples| samples.bus_current = 4096 - samples.bus_current).mistake();
    assert_eq!(found.check, Check::CurrentSign);
    assert!(found.measured < -100, "{found}");

    // More current than was allowed.
    let given = Given { current_max: Amps::from_milli(50), ..GIVEN };
    let found = Bench { given, ..Bench::default() }.mistake();
    assert_eq!((found.check, found.tolerance), (Check::CurrentLimit, 50));
}

#[test]
fn hall_lines_are_found_as_they_are_wired() {
    let wired = |order, polarity| {
        let mut bench = Bench::default();
        bench.plant.hall = HallConfig { order, polarity, ..HallConfig::default() };
        let findings = bench.run();
        let of = |check| findings.iter().find(|finding| finding.check == check).unwrap().measured;
        assert_eq!(of(Check::HallLines), 6);
        (of(Check::HallOrder), of(Check::HallPolarity))
    };
    // `order` of the plant says which sensor is at a line, parameter 262 which line is a sensor's: 3 and 4
    // are each other's inverse.
    for (order, measured) in [(0, 0), (1, 1), (2, 2), (3, 4), (4, 3), (5, 5)] {
        assert_eq!(wired(order, 0).0, measured);
    }
    assert_eq!(wired(0, 0b101), (0, 0b101));
}

#[test]
fn a_dead_hall_line_and_exchanged_phases_are_seen() {
    // Line B without a pull-up: codes with and without it are the same.
    let findings = Bench { samples: |samples| samples.hall &= 0b101, ..Bench::default() }.run();
    let of = |check| *findings.iter().find(|finding| finding.check == check).unwrap();
    assert_eq!((of(Check::HallLines).measured, of(Check::HallOrder).measured), (4, -1));

    // Two phases of the motor exchanged: the rotor goes the other way, as with two hall lines exchanged.
    let mut bench = Bench::default();
    bench.plant.motor.phase_order = [Phase::A, Phase::C, Phase::B];
    let findings = bench.run();
    let order = findings.iter().find(|finding| finding.check == Check::HallOrder).unwrap();
    assert!([1, 2, 5].contains(&order.measured), "{order}");
}

#[test]
fn the_rate_is_compared_with_another_clock() {
    assert!(pwm_rate(&Board::BENCH, 10_000, 1_000_000).passes());
    // Both ends of a centre-aligned period interrupt.
    let twice = pwm_rate(&Board::BENCH, 20_000, 1_000_000);
    assert_eq!((twice.passes(), twice.measured, twice.expected), (false, 20_000, 10_000));
    assert_eq!(pwm_rate(&Board::BENCH, 1, 0).measured, 0);
}

#[test]
fn a_check_that_cannot_be_is_refused() {
    let refused = |board, given| BoardCheck::new(board, given).unwrap_err();
    let board = Board { tick_rate: 0, ..Board::BENCH };
    assert_eq!(refused(board, GIVEN), GivenError::Board);
    // 500 ns of 100 us are 163.
    for bits in [0, 488, 8_193] {
        let duty = Duty::from_bits(bits);
        assert_eq!(refused(Board::BENCH, Given { duty, ..GIVEN }), GivenError::Duty(bits, 489, 8_192));
    }
    let shown = GivenError::Duty(9_000, 489, 8_192).to_string();
    assert_eq!(shown, "duty 9000/32768: expected 489 to 8192, three dead times to a quarter");
}

#[test]
fn a_finding_says_what_to_do() {
    let finding =
        Finding { check: Check::DeadTime, phase: Some(0), measured: 650, expected: 500, tolerance: 200 };
    assert_eq!(finding.to_string(), "ok   dead time of A: 650 ns, expected 500 +- 200");
    let wrong = Finding { measured: 1_500, ..finding }.to_string();
    assert!(
        wrong.starts_with("FAIL dead time of A: 1500 ns, expected 500 +- 200: compare the timer"),
        "{wrong}"
    );
}
