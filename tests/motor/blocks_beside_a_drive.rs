//! Tests that blocks with a drive's inputs give the drive's results, tick by tick, bit for bit.

use narx_core::blocks::{
    Commutation, CommutationSettings, Hall, HallSettings, StateMachine, StateSettings, ZeroCrossing,
    ZeroCrossingSettings,
};
use narx_core::commissioning::Mode;
use narx_core::dictionary::number;
use narx_core::motor::machine::Inputs;
use narx_core::motor::machine::event::Event;
use narx_core::motor::{Direction, Drive, PwmCommand, Samples, State, Status, Step};
use narx_core::recording::{Player, Recording};
use narx_core::units::{ElectricalAngle, ElectricalSpeed};
use narx_sim::presets::preset;
use narx_sim::session::{Session, SessionConfig};

const MOTOR: &str = "ec45-flat-50w-18v";
const SUPPLY: f64 = 18.0;

/// One tick of a drive.
pub(crate) struct Told<'a> {
    pub(crate) event: Option<&'a Event>,
    pub(crate) samples: &'a Samples,
    /// Command that was in force in the period that has ended.
    pub(crate) applied: &'a PwmCommand,
    /// Command that is the result.
    pub(crate) command: &'a PwmCommand,
    pub(crate) status: Option<&'a Status>,
    pub(crate) state: State,
}

/// Runs a session: `rpm` for 1.5 s, another speed, and Standby; then passes every tick of its recording to
/// `observe`.
pub(crate) fn beside(mode: Mode, rpm: i32, mut observe: impl FnMut(&Session, Told<'_>)) -> u32 {
    let config =
        SessionConfig { trace: false, ..SessionConfig::new(preset(MOTOR).unwrap().motor, SUPPLY, mode) };
    let mut session = Session::new(&config).unwrap();
    session.start(rpm);
    session.run(2.2);
    session.set_speed(2 * rpm.unsigned_abs() as u16);
    session.run(0.8);
    session.stop();
    session.run(0.3);
    let file = session.bench().recording();
    let recording = Recording::open(&file).unwrap();
    let mut player = Player::<Drive>::new(&recording).unwrap();
    let (mut applied, mut ticks) = (PwmCommand::default(), 0);
    for tick in recording.ticks() {
        let event = tick.unwrap().event;
        let (samples, outputs) = player.step().unwrap().unwrap();
        let told = Told {
            event: event.as_ref(),
            samples: &samples,
            applied: &applied,
            command: &outputs.command,
            status: outputs.status.as_ref(),
            state: player.drive().state(),
        };
        observe(&session, told);
        applied = outputs.command;
        ticks += 1;
    }
    ticks
}

fn parameter(session: &Session, number: u16) -> i32 {
    session.commissioning().parameters.value(number).unwrap()
}

#[test]
fn hall_commutation_and_state() {
    for rpm in [1500, -1500] {
        let torque = if rpm > 0 { Direction::Forward } else { Direction::Reverse };
        let mut blocks = None;
        let (mut compared, mut changes, mut rows) = (0, 0, Vec::new());
        let mut before = State::Initialization;
        beside(Mode::Hall, rpm, |session, told| {
            let (hall, commutation, machine) = blocks.get_or_insert_with(|| hall_blocks(session));
            let reading = hall.step(told.samples.hall, &told.samples.edges);
            match told.event {
                Some(Event::Command(command)) => machine.handle_command(*command),
                Some(Event::SetPoint(speed)) => machine.handle_set_point(*speed),
                _ => {}
            }
            let stopped = told.state != State::HallClosedLoop || reading.stopped;
            let inputs = Inputs {
                critical: false,
                unhealthy: false,
                causes_gone: true,
                stopped,
                calibrated: false,
                parameters_fit: true,
            };
            rows.extend(machine.step(&inputs).map(|change| change.row.to_string()));
            assert_eq!(machine.state(), told.state);
            if told.state != before {
                commutation.reset();
                before = told.state;
            }
            if let Some(status) = told.status {
                let place = ElectricalAngle((reading.position.angle >> 16) as u16);
                assert_eq!((reading.speed, place), (status.speed_hall, status.angle));
                let counts = hall.diagnostics();
                assert_eq!((counts.invalid, counts.jumps), (status.hall_invalid, status.hall_jumps));
            }
            if told.state == State::HallClosedLoop {
                let answer = commutation.step(reading.position, torque);
                if told.command.step != Step::Coast {
                    assert_eq!(answer, (told.command.step, told.command.commutations));
                    compared += 1;
                    changes += answer.1.iter().count();
                }
            }
        });
        assert_eq!(rows, ["T01", "T15", "T51"]);
        // A second of 8 pole pairs at 3 000 rpm and more has 2 400 sectors.
        assert!(compared > 20_000 && changes > 2_000, "{compared} ticks, {changes} changes");
    }
}

fn hall_blocks(session: &Session) -> (Hall, Commutation, StateMachine) {
    let of = |number| parameter(session, number);
    let floor = i64::from(of(number::HALL_INTERPOLATION_SPEED)) * i64::from(of(number::MOTOR_POLE_PAIRS));
    let settings = HallSettings {
        timeout_ms: of(number::HALL_PERIOD_TIMEOUT) as u32,
        interpolation_min: ElectricalSpeed::from_bits(((floor << 16) / 60) as i32),
        ..HallSettings::default()
    };
    let commutation =
        CommutationSettings { advance_cdeg: of(number::TIMING_ADVANCE) as u16, earliest: 8_192 };
    let state =
        StateSettings { command_timeout_ms: of(number::CAN_TIMEOUT) as u32, ..StateSettings::default() };
    (
        Hall::build(&settings).unwrap(),
        Commutation::build(&commutation).unwrap(),
        StateMachine::build(&state).unwrap(),
    )
}

#[test]
fn zero_crossing_and_commutation() {
    for rpm in [1500, -1500] {
        let torque = if rpm > 0 { Direction::Forward } else { Direction::Reverse };
        let mut blocks = None;
        let (mut compared, mut statuses, mut crossings, mut announced) = (0, 0, 0, 0);
        beside(Mode::Sensorless, rpm, |session, told| {
            let (crossing, commutation) = blocks.get_or_insert_with(|| sensorless_blocks(session));
            let reading = crossing.step(told.samples, told.applied, torque);
            crossings += u32::from(reading.crossing.is_some());
            if let Some(status) = told.status {
                let why = (reading.speed, reading.why, reading.margin, reading.accepted);
                let theirs =
                    (status.speed_sensorless, status.crossing, status.crossing_margin, status.crossings);
                assert_eq!(why, theirs, "tick {}", status.tick);
                statuses += 1;
            }
            // The last lock ends: from 120 degrees the rotor is brought up.
            if told.applied.step == Step::LockCA && told.command.step == Step::Coast {
                crossing.start(u32::MAX / 3 + 1, torque);
                commutation.reset();
            }
            if reading.running {
                let answer = commutation.step(reading.position, torque);
                if told.command.step != Step::Coast {
                    assert_eq!(answer, (told.command.step, told.command.commutations));
                    compared += 1;
                }
                if let (Some(time), Some(first)) = (reading.commutation, answer.1.iter().next())
                    && (8_192..65_535).contains(&time)
                {
                    assert!(time.abs_diff(first.instant.into()) < 16, "{time} for {}", first.instant);
                    announced += 1;
                }
            }
        });
        assert!(statuses > 3_000 && compared > 10_000, "{statuses} statuses, {compared} ticks");
        assert!(crossings > 2_000 && announced > 1_000, "{crossings} crossings, {announced} announced");
    }
}

pub(crate) fn sensorless_blocks(session: &Session) -> (ZeroCrossing, Commutation) {
    let of = |number| parameter(session, number);
    let commutation =
        CommutationSettings { advance_cdeg: of(number::TIMING_ADVANCE) as u16, earliest: 8_192 };
    let settings = ZeroCrossingSettings {
        blanking_us: of(number::ZC_DISCARD) as u32 * 100,
        commutation,
        // 0.01 tick is 1 us.
        delay_rising_us: of(number::ZC_DELAY),
        delay_falling_us: of(number::ZC_DELAY) + of(number::ZC_DELAY_FALLING),
        back_emf_uv_per_rpm: of(number::BACK_EMF_CONSTANT) as u32,
        pole_pairs: of(number::MOTOR_POLE_PAIRS) as u16,
        timeout_ticks: of(number::ZC_PERIOD_MAX) as u16,
        ..ZeroCrossingSettings::default()
    };
    (ZeroCrossing::build(&settings).unwrap(), Commutation::build(&commutation).unwrap())
}
