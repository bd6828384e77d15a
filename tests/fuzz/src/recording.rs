//! Target: recordings. Any bytes as a file; real ones with changed bytes; and chunks of any ticks with
//! correct check values, which are read as ticks and run.

use crate::program::Program;
use crate::real;
use crate::sound::Sound;
use narx_core::motor::{Drive, Event, Step};
use narx_core::recording::{Header, Recorder, Recording, Tick, replay};
use narx_sim::recording::RecordingBuffer;

/// Runs an input. First byte modulo 3: 0 for a file, 1 for positions and bytes that change in a real one, 2
/// for the payload of a chunk of ticks after a real state.
pub fn run(data: &[u8]) {
    let mut program = Program(data);
    match program.byte() % 3 {
        0 => {
            read(program.0);
        }
        1 => changed(program),
        _ => chunk(program.0),
    }
}

/// Ticks of a file, if all of it is valid. Read one by one or at once, the result must be the same.
fn read(file: &[u8]) -> Option<Vec<Tick>> {
    let recording = Recording::open(file).ok()?;
    let ticks: Result<Vec<Tick>, _> = recording.ticks().collect();
    assert_eq!(
        recording.verify().map(|end| end.ticks),
        ticks.as_ref().map(|ticks| ticks.len() as u64).map_err(|error| *error)
    );
    ticks.ok()
}

/// Checks that every change of one to four bytes is detected: the check value finds each within its chunk.
fn changed(mut program: Program<'_>) {
    let (file, ticks) = real::recording();
    let mut spoiled = file.to_vec();
    let at = program.word() as usize % file.len();
    for (byte, change) in spoiled[at..].iter_mut().zip(program.array::<4>()) {
        *byte ^= change;
    }
    match read(&spoiled) {
        Some(read) => assert!(spoiled == *file && read == *ticks),
        None => assert!(spoiled != *file),
    }
}

/// Checks a chunk of arbitrary ticks: those that can be read are written again to the same ticks, and two
/// drives give the same results for them.
fn chunk(payload: &[u8]) {
    let (file, _) = real::recording();
    let state = Recording::open(file).expect("a real one").state();
    let header = Header::drive(10_000, "made up");
    let mut sound = Sound::begin();
    let mut head = vec![1];
    head.extend(header.behaviour_version.to_le_bytes());
    head.extend(header.layout_version.to_le_bytes());
    head.extend(header.tick_rate.to_le_bytes());
    head.push(header.label.len() as u8);
    head.extend(header.label.bytes());
    sound.chunk(b'H', &head);
    sound.chunk(b'S', state);
    let payload = &payload[..payload.len().min(u16::MAX.into())];
    sound.chunk(b'T', payload);
    let recording = Recording::open(&sound.file).expect("all check values are right");
    assert_eq!((*recording.header(), recording.state()), (header, state));
    // Without its end chunk a file is never complete.
    recording.verify().expect_err("the end is missing");
    let ticks: Vec<Tick> = recording.ticks().map_while(Result::ok).collect();
    // With it, it has the number of ticks given there, or is refused.
    for count in [ticks.len() as u64, ticks.len() as u64 + 1] {
        let mut whole = sound.clone();
        whole.chunk(b'E', &[count.to_le_bytes(), [0; 8]].concat());
        let end = Recording::open(&whole.file).and_then(|whole| whole.verify());
        assert!(end.is_err() || count == ticks.len() as u64, "{count} ticks");
    }

    let mut drive: Drive = postcard::from_bytes(state).expect("a real one");
    let mut recorder = Recorder::new(RecordingBuffer::default(), &header, state).expect("memory is enough");
    // Coefficients that were not built have values that no drive has: `build` is what bounds their
    // arithmetic.
    let ticks: Vec<Tick> =
        ticks.into_iter().filter(|tick| !matches!(tick.event, Some(Event::Coefficients(_)))).collect();
    for tick in &ticks {
        if let Some(event) = &tick.event {
            drive.handle_event(event.clone());
        }
        let command = drive.step(&tick.samples);
        let status = drive.poll_status();
        let on = command.step != Step::Coast || !command.commutations.is_empty();
        assert!(!on || drive.state().is_driving(), "the bridge is on in {}", drive.state().name());
        recorder
            .record(tick.event.as_ref(), &tick.samples, &command, status.as_ref())
            .expect("an event that was read has room");
    }
    let again = recorder.finish().expect("memory is enough").0;
    assert_eq!(read(&again), Some(ticks));
    let outcome = replay::<Drive>(&Recording::open(&again).expect("our own")).expect("our own");
    assert!(outcome.is_identical());
}
