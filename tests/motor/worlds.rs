//! Worlds in which everything goes wrong at once: a few here, hours of them by `cargo xtask worlds`.

use narx_core::motor::State;
use xtask::bench::map;
use xtask::worlds::{KINDS, run};

#[test]
fn nothing_happens_that_may_not_and_afterwards_the_motor_turns() {
    let seeds: Vec<u64> = (1_000_001..=1_000_024).collect();
    let stories = map(&seeds, |seed| run(*seed, false));
    for story in &stories {
        assert!(story.broken.is_none(), "{story}");
    }
    // A world without mishaps, or one in which no drive ever drives, would prove nothing.
    for (index, kind) in KINDS.iter().enumerate() {
        assert!(stories.iter().any(|story| story.mishaps[index] > 0), "no {}", kind.name());
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
