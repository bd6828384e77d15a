//! Tests that the bench measures the commutation angle that was set.

use narx_core::commissioning::Mode;
use narx_core::dictionary::number;
use narx_core::motor::Step;
use narx_sim::commutations::Commutations;
use narx_sim::presets::preset;
use narx_sim::session::{Session, SessionConfig};

const MOTOR: &str = "bly172s-24v";

fn config(mode: Mode) -> SessionConfig {
    SessionConfig { trace: false, ..SessionConfig::new(preset(MOTOR).unwrap().motor, 24.0, mode) }
}

/// A session 2.5 s after power-up, at `rpm`.
fn running(config: &SessionConfig, rpm: i32) -> Session {
    let mut session = Session::new(config).unwrap();
    session.start(rpm);
    session.run(2.5);
    session
}

/// Commutations of the next second, and the number of times that the bridge was switched off.
fn watch(session: &mut Session) -> (Commutations, u32) {
    let (mut commutations, mut coasted, mut off) = (Commutations::default(), 0, false);
    // The first change has no pattern before it.
    commutations.watch(session.bench());
    commutations.clear();
    for _ in 0..10_000 {
        session.step();
        commutations.watch(session.bench());
        let coasts = session.bench().command().step == Step::Coast;
        coasted += u32::from(coasts && !off);
        off = coasts;
    }
    (commutations, coasted)
}

/// A motor that is to slow down coasts. Switching the bridge off and on again is no commutation; all others
/// are within the promised 5 degrees.
#[test]
fn bridge_off_and_on_is_no_commutation() {
    let mut config = config(Mode::Sensorless);
    config.motor.static_friction = 0.0;
    config.motor.inertia *= 5.0;
    config.parameters = vec![(number::SPEED_RATE, 10_000.0)];
    let mut session = running(&config, 3_000);
    session.set_speed(2_700);
    let (commutations, coasted) = watch(&mut session);
    assert!(coasted > 0, "it did not coast");
    let errors = commutations.errors();
    assert!(errors.len() > 500, "{} commutations", errors.len());
    let worst = errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
    assert!(worst <= 5.0, "{worst:.1} degrees after {coasted} times of coasting");
}

/// A commutation that is early or late by a known angle is measured with that angle, in either direction, and
/// also beyond half a sector.
#[test]
fn known_angles_are_seen() {
    for (offset, advance) in [(0.0, 0.0), (0.0, 10.0), (10.0, 0.0), (35.0, 0.0)] {
        for rpm in [2_000_i32, -2_000] {
            let late = offset * f64::from(rpm.signum()) - advance;
            let parameters = vec![(number::TIMING_ADVANCE, advance)];
            let config = SessionConfig { hall_offset_deg: offset, parameters, ..config(Mode::Hall) };
            let mean = watch(&mut running(&config, rpm)).0.mean_and_jitter().0;
            assert!((mean - late).abs() < 2.0, "{rpm} rpm: {mean:.1} degrees late, not {late:.1}");
        }
    }
}
