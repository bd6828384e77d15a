//! Actions in a scenario.

use super::scenario::{parameter, within};
use narx_core::bus::Frame;
use narx_core::bus::candump::{Content, Line};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::machine::event::Health;
use narx_sim::plant::{Injection, InjectionOptions, Phase};
use serde::Deserialize;

/// An action at its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Time from power-up, s.
    pub time: f64,
    /// Action at that time.
    pub action: Action,
}

/// Action of the master or of the surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// The master requests a speed, mechanical rpm; negative is Reverse.
    Start(i32),
    /// The master requests Standby.
    Stop,
    /// The master requests a shutdown (motor mode 3).
    Shutdown,
    /// The master stops sending, or goes on.
    Silence(bool),
    /// The master writes a parameter: number, raw value.
    Set(u16, i32),
    /// A fault begins.
    Inject(Injection),
    /// A fault ends.
    Clear(Injection),
    /// Open-circuit voltage of the supply, V.
    Supply(f64),
    /// Constant load on the shaft, N m.
    Load(f64),
    /// A frame, unchanged, from the master's place on the bus.
    Send(Frame),
    /// This many frames on the bus are destroyed.
    Disturb(u32),
    /// Result of the shell's checks of store and self-tests.
    Health(Health),
}

/// One entry of `at`: a time and exactly one of the other keys.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StepKeys {
    time: f64,
    start: Option<i32>,
    #[serde(default)]
    stop: bool,
    #[serde(default)]
    shutdown: bool,
    silence: Option<bool>,
    set: Option<SetKeys>,
    inject: Option<FaultKeys>,
    clear: Option<FaultKeys>,
    supply: Option<f64>,
    load: Option<f64>,
    send: Option<String>,
    disturb: Option<u32>,
    health: Option<HealthKeys>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HealthKeys {
    /// Names of fault bits 26, 30, 31.
    #[serde(default)]
    store: Vec<String>,
    #[serde(default)]
    self_test_failed: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SetKeys {
    parameter: NameOrNumber,
    value: f64,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "a parameter's number or name")]
enum NameOrNumber {
    Number(u16),
    Name(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FaultKeys {
    fault: String,
    value: Option<f64>,
    phase: Option<PhaseKey>,
    high: Option<bool>,
}

#[derive(Clone, Copy, Deserialize)]
enum PhaseKey {
    A,
    B,
    C,
}

impl StepKeys {
    /// Checks the entry; returns the step, within a run of `seconds`.
    pub(super) fn checked(self, seconds: f64) -> Result<Step, String> {
        let time = within("at.time", self.time, 0.0, seconds, "s")?;
        let mut actions = Vec::new();
        if let Some(rpm) = self.start {
            actions.push(Action::Start(within("at.start", f64::from(rpm), -65535.0, 65535.0, "rpm")? as i32));
        }
        if self.stop {
            actions.push(Action::Stop);
        }
        if self.shutdown {
            actions.push(Action::Shutdown);
        }
        actions.extend(self.silence.map(Action::Silence));
        if let Some(set) = self.set {
            let name = match set.parameter {
                NameOrNumber::Number(number) => number.to_string(),
                NameOrNumber::Name(name) => name,
            };
            let (number, raw) = parameter("at.set", &name, set.value)?;
            actions.push(Action::Set(number, raw));
        }
        if let Some(fault) = self.inject {
            actions.push(Action::Inject(fault.checked("at.inject", true)?));
        }
        if let Some(fault) = self.clear {
            actions.push(Action::Clear(fault.checked("at.clear", false)?));
        }
        if let Some(volts) = self.supply {
            actions.push(Action::Supply(within("at.supply", volts, 0.0, 80.0, "V")?));
        }
        if let Some(torque) = self.load {
            actions.push(Action::Load(within("at.load", torque, 0.0, 10.0, "N m")?));
        }
        if let Some(text) = self.send {
            actions.push(Action::Send(frame(&text)?));
        }
        actions.extend(self.disturb.map(Action::Disturb));
        if let Some(health) = self.health {
            actions.push(Action::Health(health.checked()?));
        }
        match actions[..] {
            [action] => Ok(Step { time, action }),
            _ => Err(format!("at.time = {time}: exactly one action, there are {}", actions.len())),
        }
    }
}

/// Parses a frame in candump's form: `1552A0C9#0011`, `601#R`.
fn frame(text: &str) -> Result<Frame, String> {
    let line = format!("(0) master {text}");
    match Line::parse(line.as_bytes()) {
        Ok(Some(Line { content: Content::Frame(frame), .. })) => Ok(frame),
        Ok(_) => Err(format!("at.send = \"{text}\": must be a frame of classic CAN")),
        Err(error) => Err(format!("at.send = \"{text}\": {error}")),
    }
}

impl HealthKeys {
    fn checked(self) -> Result<Health, String> {
        let store = FaultWord::STORE_MISMATCH | FaultWord::STORE_ABSENT | FaultWord::STORE_VERSION;
        let mut store_faults = FaultWord::empty();
        for name in &self.store {
            let bit = FaultWord::from_name(name).filter(|bit| store.contains(*bit));
            store_faults |= bit.ok_or_else(|| {
                let names: Vec<&str> = store.iter_names().map(|(name, _)| name).collect();
                format!("at.health.store = \"{name}\": unknown; one of {}", names.join(", "))
            })?;
        }
        Ok(Health { store_faults, self_test_failed: self.self_test_failed })
    }
}

impl FaultKeys {
    /// Returns the fault; to end one, its value is not used and may be left out.
    fn checked(&self, key: &str, begins: bool) -> Result<Injection, String> {
        let phase = self.phase.map(|phase| match phase {
            PhaseKey::A => Phase::A,
            PhaseKey::B => Phase::B,
            PhaseKey::C => Phase::C,
        });
        let any = || (!begins).then(|| Injection::some_value(&self.fault));
        let options =
            InjectionOptions { value: self.value.or_else(any), phase, high: self.high.unwrap_or(false) };
        Injection::named(&self.fault, options)
            .map_err(|error| format!("{key}.fault = \"{}\": {error}", self.fault))
    }
}
