//! The promise about faults: with any fault in any state, the bridge is off in the tick in which the fault
//! qualifies.

use super::Context;
use super::trial::Trial;
use narx_core::commissioning::{Mode, Nameplate};
use narx_core::motor::{Board, Cause, State, Step};
use narx_host::parallel::map;
use narx_report::figures::{Figure, Part};
use narx_sim::can::Attachment;
use narx_sim::plant::{Injection, Phase, PlantConfig};
use narx_sim::presets::preset;

/// The motor and supply of these runs.
const MOTOR: &str = "bly172s-24v";
const SUPPLY: f64 = 24.0;

/// An event, and the fault that must follow.
#[derive(Clone, Copy)]
enum Trouble {
    Plant(Injection, Cause),
    /// The master stops sending, as when its cable is pulled.
    Silence,
    /// The master requests motor mode 3.
    Shutdown,
}

const TROUBLES: [(&str, Trouble); 7] = [
    ("over-voltage", Trouble::Plant(Injection::Supply(66.0), Cause::OverVoltage)),
    ("under-voltage", Trouble::Plant(Injection::Supply(10.0), Cause::UnderVoltage)),
    ("over-current", Trouble::Plant(Injection::Leak(2.0), Cause::OverCurrent)),
    ("gate driver", Trouble::Plant(Injection::Driver(Phase::B), Cause::DriverLine)),
    ("break input", Trouble::Plant(Injection::Break, Cause::EmergencyLine)),
    ("master silent", Trouble::Silence),
    ("shutdown request", Trouble::Shutdown),
];

const STATES: [State; 6] = [
    State::Standby,
    State::RotorLock,
    State::OpenLoop,
    State::SensorlessClosedLoop,
    State::HallClosedLoop,
    State::SensorlessAutoRestart,
];

/// Tries every trouble in every state in which something may be driven, and in Standby.
pub(super) fn part(context: &Context<'_>) -> Part {
    let mut points = Vec::new();
    for trouble in TROUBLES {
        // In Standby a master need not send.
        let anywhere = !matches!(trouble.1, Trouble::Silence);
        points.extend(
            STATES.into_iter().filter(|s| anywhere || *s != State::Standby).map(|state| (trouble, state)),
        );
    }
    let results = map(&points, |((_, trouble), state)| latency(*trouble, *state, &context.board));
    let mut failures = Vec::new();
    let mut longest = TROUBLES.map(|(name, _)| (name, 0_u32));
    for (((name, _), state), result) in points.iter().zip(&results) {
        match result {
            Ok(ticks) => longest
                .iter_mut()
                .filter(|(of, _)| of == name)
                .for_each(|(_, most)| *most = (*most).max(*ticks)),
            Err(why) => failures.push(format!("{name} in {}: {why}", state.name())),
        }
    }
    let kept = results.len() - failures.len();
    let share = 100.0 * kept as f64 / results.len().max(1) as f64;
    let mut figures = vec![
        Figure::new("critical faults that turn the bridge off in the tick in which they qualify", share, "%")
            .at_least(100.0)
            .note(format!("{kept} of {} troubles and states", results.len())),
    ];
    figures.extend(longest.iter().map(|(name, ticks)| {
        Figure::new(format!("{name}: from cause to bridge off, longest"), f64::from(*ticks), "ticks")
    }));
    Part::new(figures, failures)
}

/// Number of ticks from the cause until the bridge is off.
fn latency(trouble: Trouble, state: State, board: &Board) -> Result<u32, String> {
    let mode = if state == State::HallClosedLoop { Mode::Hall } else { Mode::Sensorless };
    let motor = preset(MOTOR).ok_or("no such motor")?;
    let plate = Nameplate {
        motor: motor.motor.figures(),
        rated_current: motor.data.rated_current,
        supply: SUPPLY,
        open_loop_speed: None,
    };
    let commissioning = plate.commission_on(board, mode, None).map_err(|error| error.to_string())?;
    let mut plant = PlantConfig { board: *board, ..PlantConfig::new(motor.motor, SUPPLY) };
    plant.angle_deg = 77.0;
    let mut trial = Trial::new(&plant, &commissioning, "", false);
    if state != State::Standby {
        trial.start(2_000);
    }
    if state == State::SensorlessAutoRestart {
        trial.until(5.0, |t| t.state() == State::SensorlessClosedLoop).ok_or("no closed loop")?;
        trial.run_while(0.5, |_| true);
        trial.bench.plant_mut().inject(Injection::BlockedRotor);
    }
    trial.until(5.0, |trial| trial.state() == state).ok_or("the state was not reached")?;
    trial.run_while(0.02, |_| true);
    let expected = match trouble {
        Trouble::Plant(injection, cause) => {
            trial.bench.plant_mut().inject(injection);
            cause
        }
        Trouble::Silence => {
            trial.bench.set_host(Attachment::Detached);
            Cause::CommandTimeout
        }
        Trouble::Shutdown => {
            trial.shut_down();
            Cause::ShutdownCommanded
        }
    };
    // The state machine reports every change of the fault word in the tick of the change.
    let seconds = trial
        .until(2.0, |trial| !trial.bench.status().critical.is_empty())
        .ok_or_else(|| format!("{expected:?} was not reported in 2 s"))?;
    let command = trial.bench.command();
    let off = command.step == Step::Coast && command.commutations.iter().next().is_none();
    let status = trial.bench.status();
    if !off || status.state != State::Fault {
        return Err(format!("bridge on in {} although {:?}", status.state.name(), status.critical));
    }
    if status.extended_code != expected as u16 {
        return Err(format!("code {:#06x} instead of {:#06x}", status.extended_code, expected as u16));
    }
    Ok((seconds / trial.tick_seconds).round() as u32)
}
