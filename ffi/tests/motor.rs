//! The control tick alone, as C calls it, answers what the drive answers: over every vector that begins at
//! power-up.

use narx::narx_status_t::NARX_OK;
use narx::*;
use narx_core::motor::machine::event::Health;
use narx_core::motor::{Coefficients, Drive, Event, RunRequest};
use narx_core::recording::{Recording, Tick};
use std::fs;
use std::mem::MaybeUninit;
use std::path::Path;

/// Gives the motor an event. `false` for one that only a node has: a failure of the store or of a self-test,
/// or a rejected set.
fn take(motor: *mut narx_motor_t, event: &Event) -> bool {
    // SAFETY: the motor is valid, as are the coefficients.
    let status = unsafe {
        match event {
            Event::Command(command) => {
                let mode = match command.request {
                    RunRequest::Standby => 0,
                    RunRequest::Drive => 1,
                    RunRequest::Reverse => 2,
                    RunRequest::Shutdown => 3,
                };
                narx_motor_handle_command(motor, mode, command.speed.to_bits())
            }
            Event::SetPoint(speed) => narx_motor_handle_set_point(motor, speed.to_bits()),
            Event::Coefficients(coefficients) => narx_motor_change_coefficients(motor, coefficients),
            Event::Slow(slow) => {
                narx_motor_handle_inputs(motor, slow.temperature.to_bits(), slow.pressure.to_bits())
            }
            Event::CalibrateHall(run) => narx_motor_calibrate_hall(motor, (*run).into()),
            // All is well, as the motor takes for granted.
            Event::Health(health) if *health == Health::default() => NARX_OK,
            Event::Health(_) | Event::CoefficientsRejected => return false,
        }
    };
    assert_eq!(status, NARX_OK);
    true
}

/// Number of ticks that were alike: all, or those before an event that only a node has.
fn compare(name: &str, recording: &Recording<'_>) -> Option<u64> {
    let mut drive: Drive = postcard::from_bytes(recording.state()).unwrap();
    let (coefficients, _) = postcard::take_from_bytes::<Coefficients>(recording.state()).unwrap();
    if drive != Drive::new(coefficients) {
        return None;
    }
    let mut motor = MaybeUninit::<narx_motor_t>::zeroed();
    let motor = motor.as_mut_ptr();
    // SAFETY: the memory is as large and aligned as the type, and nothing else uses it.
    assert_eq!(unsafe { narx_motor_init(motor, size_of::<narx_motor_t>(), &coefficients) }, NARX_OK);
    let mut ticks = 0;
    for tick in recording.ticks() {
        let Tick { event, samples } = tick.unwrap();
        if let Some(event) = event {
            if !take(motor, &event) {
                break;
            }
            drive.handle_event(event);
        }
        let (mut command, mut report) = (MaybeUninit::zeroed(), MaybeUninit::<narx_motor_report_t>::zeroed());
        // SAFETY: all pointers are valid, and the calls write what is read.
        let (command, report, is_due) = unsafe {
            assert_eq!(
                narx_motor_step(motor, &narx_samples_t::from(&samples), command.as_mut_ptr()),
                NARX_OK
            );
            let is_due = narx_motor_poll_report(motor, report.as_mut_ptr()) == NARX_OK;
            (command.assume_init(), report.assume_init(), is_due)
        };
        let expected = narx_pwm_command_t::from(drive.step(&samples));
        assert_eq!(format!("{command:?}"), format!("{expected:?}"), "{name}, tick {ticks}");
        let status = drive.poll_status();
        assert_eq!(is_due, status.is_some(), "{name}, tick {ticks}");
        if let Some(status) = status {
            let expected = narx_motor_report_t::from(status);
            assert_eq!(format!("{report:?}"), format!("{expected:?}"), "{name}, tick {ticks}");
        }
        ticks += 1;
    }
    Some(ticks)
}

#[test]
fn answers_are_those_of_the_drive() {
    let vectors = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/vectors");
    let (mut compared, mut ticks) = (0, 0);
    for entry in fs::read_dir(vectors).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "narxrec") {
            let bytes = fs::read(&path).unwrap();
            let Ok(recording) = Recording::open(&bytes) else { continue };
            if let Some(alike) = compare(&path.display().to_string(), &recording) {
                (compared, ticks) = (compared + 1, ticks + alike);
            }
        }
    }
    println!("{compared} vectors, {ticks} ticks");
    assert!(compared >= 40 && ticks > 400_000, "{compared} vectors, {ticks} ticks");
}
