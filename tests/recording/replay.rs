//! Tests of replay against a stand-in for the drive that answers with its inputs so far.

use super::support::{Noise, turning};
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::motor::machine::event::{Command, Event, RunRequest, Status};
use narx_core::motor::{Board, Coefficients, Drive, PwmCommand, Samples};
use narx_core::recording::{
    BEHAVIOUR_VERSION, Header, Outcome, Recorder, Recording, ReplayError, Replayable, replay, replay_until,
    replay_with,
};
use narx_core::units::ElectricalSpeed;
use narx_sim::plant::{MotorConfig, Plant, PlantConfig};
use narx_sim::recording::RecordingBuffer;
use serde::{Deserialize, Serialize};

/// Stand-in that adds up its inputs and reports every tenth tick.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Accumulator {
    sum: u16,
    steps: u64,
}

impl Replayable for Accumulator {
    fn handle_event(&mut self, _: Event) {
        self.sum = self.sum.wrapping_mul(3);
    }
    fn step(&mut self, samples: &Samples) -> PwmCommand {
        self.sum = self.sum.wrapping_add(samples.phase_voltage[0]).wrapping_add(u16::from(samples.hall));
        self.steps += 1;
        PwmCommand { sample_at: self.sum, ..PwmCommand::default() }
    }
    fn poll_status(&mut self) -> Option<Status> {
        self.steps.is_multiple_of(10).then(|| Status { tick: self.steps, ..Status::default() })
    }
}

fn recorded(behaviour_version: u16) -> Vec<u8> {
    let mut drive = Accumulator { sum: 77, steps: 5 };
    let mut state = [0; 32];
    let state = postcard::to_slice(&drive, &mut state).unwrap();
    let header = Header { behaviour_version, ..Header::drive(10_000, "accumulator") };
    let mut recorder = Recorder::new(RecordingBuffer::default(), &header, state).unwrap();
    for tick in turning(500, &mut Noise(5)) {
        if let Some(event) = tick.event.clone() {
            drive.handle_event(event);
        }
        let command = drive.step(&tick.samples);
        let status = drive.poll_status();
        recorder.record(tick.event.as_ref(), &tick.samples, &command, status.as_ref()).unwrap();
    }
    recorder.finish().unwrap().0
}

#[test]
fn the_same_drive_answers_the_same() {
    let file = recorded(BEHAVIOUR_VERSION);
    let recording = Recording::open(&file).unwrap();
    let outcome = replay::<Accumulator>(&recording).unwrap();
    assert!(outcome.is_identical());
    assert_eq!((outcome.ticks, outcome.other_behaviour), (500, None));
    let mut seen = Vec::new();
    replay_with::<Accumulator>(&recording, |drive, samples, command| {
        seen.push((drive.steps, samples.tick, command.sample_at));
    })
    .unwrap();
    assert_eq!(seen.len(), 500);
    assert_eq!((seen[0].0, seen[0].1), (6, 1_000));
}

/// Recording of the real drive, which turns a simulated motor with hall sensors and gets a parameter set on
/// the way.
fn recorded_run(ticks: u64) -> (Vec<u8>, Drive) {
    let motor = MotorConfig { static_friction: 0.002, ..MotorConfig::default() };
    let plate =
        Nameplate { motor: motor.figures(), rated_current: Some(4.0), supply: 24.0, open_loop_speed: None };
    let commissioned = plate.commission(Mode::Hall).unwrap();
    let Ok(coefficients) = Coefficients::build(&commissioned.parameters, &Board::BENCH) else {
        panic!("commissioned parameters do not build")
    };
    let mut drive = Drive::new(coefficients);
    let mut plant = Plant::new(&PlantConfig::new(motor, 24.0));
    let mut state = [0; 4_096];
    let state = postcard::to_slice(&drive, &mut state).unwrap();
    println!("serialised drive: {} bytes", state.len());
    let mut recorder = Recorder::new(RecordingBuffer::default(), &Header::drive(10_000, ""), state).unwrap();
    let speed = ElectricalSpeed::from_ratio(2_000 * 4, 60);
    for k in 0..ticks {
        let samples = plant.sample();
        let event = match k {
            8_000 => Some(Event::Coefficients(coefficients)),
            _ if k % 500 != 0 => None,
            5_500.. => Some(Event::Command(Command { request: RunRequest::Drive, speed })),
            _ => Some(Event::Command(Command::default())),
        };
        if let Some(event) = event.clone() {
            drive.handle_event(event);
        }
        let command = drive.step(&samples);
        recorder.record(event.as_ref(), &samples, &command, drive.poll_status().as_ref()).unwrap();
        plant.finish_period(&command);
    }
    assert!(plant.observe().speed > 100.0, "the motor must turn: {} rad/s", plant.observe().speed);
    (recorder.finish().unwrap().0, drive)
}

#[test]
fn the_real_drive_on_a_simulated_motor() {
    let (file, drive) = recorded_run(15_000);
    println!("15000 ticks: {} bytes, {:.2} a tick", file.len(), file.len() as f64 / 15_000.0);
    assert!(file.len() < 12 * 15_000);
    let mut last = None;
    let outcome = replay_with(&Recording::open(&file).unwrap(), |drive: &Drive, _, _| {
        last = Some(drive.clone());
    })
    .unwrap();
    assert!(outcome.is_identical());
    assert_eq!(outcome.ticks, 15_000);
    assert!(last.unwrap() == drive);
}

#[test]
fn another_drive_does_not() {
    /// Stand-in that ignores the events.
    #[derive(Deserialize)]
    struct Deaf(Accumulator);
    impl Replayable for Deaf {
        fn handle_event(&mut self, _: Event) {}
        fn step(&mut self, samples: &Samples) -> PwmCommand {
            self.0.step(samples)
        }
        fn poll_status(&mut self) -> Option<Status> {
            self.0.poll_status()
        }
    }
    let file = recorded(BEHAVIOUR_VERSION);
    assert!(!replay::<Deaf>(&Recording::open(&file).unwrap()).unwrap().is_identical());
}

#[test]
fn another_behaviour_is_a_warning() {
    let file = recorded(BEHAVIOUR_VERSION + 1);
    let outcome = replay::<Accumulator>(&Recording::open(&file).unwrap()).unwrap();
    assert!(
        matches!(outcome, Outcome { other_behaviour: Some(version), .. } if version == BEHAVIOUR_VERSION + 1)
    );
    assert!(outcome.is_identical());
}

#[test]
fn damage_and_foreign_states_are_errors() {
    /// Stand-in that needs more state than the recording has.
    #[derive(Deserialize)]
    struct Foreign(Accumulator, #[expect(dead_code, reason = "only its size matters")] [u64; 9]);
    impl Replayable for Foreign {
        fn handle_event(&mut self, _: Event) {}
        fn step(&mut self, samples: &Samples) -> PwmCommand {
            self.0.step(samples)
        }
        fn poll_status(&mut self) -> Option<Status> {
            None
        }
    }
    let mut file = recorded(BEHAVIOUR_VERSION);
    assert_eq!(replay::<Foreign>(&Recording::open(&file).unwrap()).unwrap_err(), ReplayError::State);
    let middle = file.len() / 2;
    file[middle] ^= 1;
    let error = replay::<Accumulator>(&Recording::open(&file).unwrap()).unwrap_err();
    assert!(matches!(error, ReplayError::Read(_)));
}

#[test]
fn a_prefix_ends_with_the_outputs_of_its_last_tick() {
    let file = recorded(BEHAVIOUR_VERSION);
    let recording = Recording::open(&file).unwrap();
    let whole = replay::<Accumulator>(&recording).unwrap();
    let mut commands = Vec::new();
    replay_with::<Accumulator>(&recording, |_, samples, command| commands.push((samples.tick, *command)))
        .unwrap();

    let none = replay_until::<Accumulator>(&recording, 0).unwrap();
    assert_eq!((none.ticks, none.last), (0, None));
    for ticks in [1, 10, 499, 500] {
        let prefix = replay_until::<Accumulator>(&recording, ticks).unwrap();
        let last = prefix.last.unwrap();
        assert_eq!((prefix.ticks, (last.tick, last.command)), (ticks, commands[ticks as usize - 1]));
        // The accumulator began with 5 steps and reports every tenth.
        assert_eq!(last.status.is_some(), (ticks + 5) % 10 == 0);
    }
    let all = replay_until::<Accumulator>(&recording, u64::MAX).unwrap();
    assert_eq!((all.ticks, all.digest), (500, whole.digest));
}

#[test]
fn outputs_are_told_field_by_field() {
    let file = recorded(BEHAVIOUR_VERSION);
    let recording = Recording::open(&file).unwrap();
    let prefix = replay_until::<Accumulator>(&recording, 5).unwrap();
    insta::assert_snapshot!(prefix.last.unwrap());
}
