//! Tests of worlds with many faults at once: a few here, hours of them by `cargo xtask worlds`.

use narx_core::motor::State;
use narx_host::parallel::map;
use narx_lab::worlds::{Broken, KINDS, NEVER, Never, Story, Total, run};
use narx_sim::plant::{Injection, InjectionOptions, Phase};

#[test]
fn nothing_happens_that_may_not_and_afterwards_the_motor_turns() {
    let seeds: Vec<u64> = (1_000_001..=1_000_024).collect();
    let stories = map(&seeds, |seed| run(*seed, false));
    for story in &stories {
        assert!(story.broken.is_none(), "{story}");
    }
    // Without mishaps, or without a drive that ever drives, the test would prove nothing.
    for (index, kind) in KINDS.iter().enumerate() {
        assert!(stories.iter().any(|story| story.mishaps[index] > 0), "no {}", kind.name());
    }
    for (index, name) in Injection::NAMES.into_iter().enumerate() {
        assert!(stories.iter().any(|story| story.injections[index] > 0), "no {name}");
    }
    for state in State::ALL {
        assert!(stories.iter().any(|story| story.states[state as usize] > 0), "never in {}", state.name());
    }
}

#[test]
fn a_world_is_its_number() {
    assert_eq!(run(1_000_001, false), run(1_000_001, false));
    assert_ne!(run(1_000_001, false).digest, run(1_000_002, false).digest);
}

/// The sum has the figures of the worlds, and a broken invariant is listed under its name, with the number of
/// the world.
#[test]
fn worlds_add_up() {
    let story = run(1_000_001, false);
    let broken = Broken { time: 0.5, never: Never::Store, what: "gone".into() };
    let other = Story { seed: 7, unable: true, broken: Some(broken), ..story.clone() };
    let mut total = Total::new("command".into(), "commit".into(), 1);
    total.add(&story);
    total.add(&other);
    assert_eq!((total.worlds, total.boots, total.frames), (2, 2 * story.boots, 2 * story.frames));
    assert!((total.hours * 3600.0 - 2.0 * story.seconds).abs() < 1e-6, "{} h", total.hours);
    for (kind, count) in KINDS.iter().zip(story.mishaps) {
        assert_eq!(total.mishaps[kind.name()], 2 * count, "{}", kind.name());
    }
    let breaks: u64 = total.injections.values().sum();
    assert_eq!(breaks, total.mishaps["breaks"]);
    for never in NEVER {
        assert_eq!(total.invariants[never.name()], u64::from(never == Never::Store), "{}", never.name());
    }
    assert_eq!(total.failures, [(7, "at 0.5000 s: gone".to_owned())]);
    assert_eq!(total.unable, [7]);
}

#[test]
fn every_injection_counts_under_its_own_name() {
    for (index, kind) in Injection::KINDS.iter().enumerate() {
        let value = kind.value.map(|value| value.example);
        let options = InjectionOptions { value, phase: kind.phase.then_some(Phase::A), high: kind.high };
        assert_eq!(Injection::named(kind.name, options).unwrap().index(), index, "{}", kind.name);
    }
}
