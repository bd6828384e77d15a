use narx_core::motor::event::{Event, Status};
use narx_core::motor::{Drive, PwmCommand, Samples};
use narx_core::recording::{Recording, Replayable, replay_with};
use serde::Deserialize;
use xtask::bench::map;
use xtask::vectors::{directory, scenarios};
use xtask::worlds::windows;
/// A drive, beside one that asks every station in every tick.
#[derive(Deserialize)]
struct Pair {
    drive: Drive,
    #[serde(skip)]
    woken: Option<Drive>,
    #[serde(skip)]
    tick: u64,
    /// The first tick in which they answer differently, and what the woken one answers.
    #[serde(skip)]
    differs: Option<String>,
}

impl Pair {
    fn woken(&mut self) -> &mut Drive {
        self.woken.get_or_insert_with(|| self.drive.clone())
    }

    fn compare<T: PartialEq + std::fmt::Debug>(&mut self, found: &T, expected: &T) {
        if self.differs.is_none() && found != expected {
            self.differs = Some(format!("tick {}: {found:?}, woken {expected:?}", self.tick));
        }
    }
}

impl Replayable for Pair {
    fn handle_event(&mut self, event: Event) {
        self.woken().handle_event(&event);
        self.drive.handle_event(event);
    }
    fn step(&mut self, samples: &Samples) -> PwmCommand {
        let woken = self.woken();
        woken.wake();
        let expected = woken.step(samples);
        let found = self.drive.step(samples);
        if std::env::var("DBG").is_ok_and(|t| {
            let t: u64 = t.parse().unwrap();
            (t - 30..=t + 1).contains(&samples.tick)
        }) {
            let a = format!("{:#?}", self.drive);
            let b = format!("{:#?}", self.woken.as_ref().unwrap());
            println!("== {}", samples.tick);
            let mut path = vec![];
            for (x, y) in a.lines().zip(b.lines()) {
                if x.trim_end().ends_with('{') {
                    path.push(x.trim().to_string());
                }
                if x.trim().starts_with('}') {
                    path.pop();
                }
                if x != y {
                    println!("{}  {} | {}", path.last().cloned().unwrap_or_default(), x.trim(), y.trim());
                }
            }
        }
        self.tick = samples.tick;
        self.compare(&found, &expected);
        found
    }
    fn poll_status(&mut self) -> Option<Status> {
        let expected = self.woken().poll_status();
        let found = self.drive.poll_status();
        self.compare(&found, &expected);
        found
    }
}

/// Ticks of a recording, throughout which both answer alike.
fn replay(bytes: &[u8]) -> Result<u64, String> {
    let recording = Recording::open(bytes).map_err(|error| format!("{error:?}"))?;
    let mut differs = None;
    let outcome = replay_with(&recording, |pair: &Pair, _, _| differs.clone_from(&pair.differs))
        .map_err(|error| format!("{error:?}"))?;
    differs.map_or(Ok(outcome.ticks), Err)
}

fn main() {
    let root = std::path::Path::new(".");
    if std::env::args().nth(1).as_deref() != Some("worlds") {
        let mut scenarios = scenarios(root).unwrap();
        if let Ok(o) = std::env::var("ONLY") {
            scenarios.retain(|s| s.name == o);
        }
        let _ = map(&scenarios, |scenario| {
            let path = directory(root).join(format!("{}.narxrec", scenario.name));
            let bytes = std::fs::read(&path).unwrap();
            if let Err(e) = replay(&bytes) {
                println!("VECTOR {} {}", scenario.name, e);
            }
        });
    }
    if let Some(n) = std::env::args().nth(2) {
        let n: u64 = n.parse().unwrap();
        let from: u64 = std::env::args().nth(3).map_or(1, |v| v.parse().unwrap());
        let seeds: Vec<u64> = (from..=n).collect();
        let c: Vec<u64> = map(&seeds, |seed| {
            let mut ticks = 0;
            for window in windows(*seed) {
                match replay(&window.recording) {
                    Ok(t) => ticks += t,
                    Err(e) => println!("WORLD {seed} {:?} {}", window.state, e),
                }
            }
            ticks
        });
        println!("{} ticks", c.iter().sum::<u64>());
    }
}
