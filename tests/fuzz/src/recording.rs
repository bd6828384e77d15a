//! Recordings: any bytes as a file; real ones with changed bytes; and chunks of any ticks whose check values are right, which read as ticks and
//! run.

use crate::program::Program;
use crate::real;
use crate::sound::Sound;
use narx_core::motor::{Drive, Event, Step};
use narx_core::recording::{Header, Recorder, Recording, Tick, replay};
use narx_sim::recording::RecordingBuffer;

/// First byte modulo 3: 0 the file, 1 places and bytes that change in a real one, 2 the payload of a chunk of ticks behind a real state.
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

/// The ticks of a file, if all of it is right; read one by one or at once, it says the same.
fn read(file: &[u8]) -> Option<Vec<Tick>> {
    let recording = Recording::open(file).ok()?;
    let ticks: Result<Vec<Tick>, _> = recording.ticks().collect();
    assert_eq!(
        recording.verify().map(|end| end.ticks),
        ticks.as_ref().map(|ticks| ticks.len() as u64).map_err(|error| *error)
    );
    ticks.ok()
}

/// No change of one to four bytes goes unseen: the check value finds each within its chunk.
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

/// Ticks that somebody made up: what reads is written again to the same ticks, and two drives do the same with them.
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
    // Without its end it is never whole.
    recording.verify().expect_err("the end is missing");
    let ticks: Vec<Tick> = recording.ticks().map_while(Result::ok).collect();
    // With it, it has as many ticks as that says, or is refused.
    for count in [ticks.len() as u64, ticks.len() as u64 + 1] {
        let mut whole = sound.clone();
        whole.chunk(b'E', &[count.to_le_bytes(), [0; 8]].concat());
        let end = Recording::open(&whole.file).and_then(|whole| whole.verify());
        assert!(end.is_err() || count == ticks.len() as u64, "{count} ticks");
    }

    let mut drive: Drive = postcard::from_bytes(state).expect("a real one");
    let mut recorder = Recorder::new(RecordingBuffer::default(), &header, state).expect("memory is enough");
    // Coefficients that nobody has built are numbers that no drive has: their arithmetic is bounded by `build`.
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
