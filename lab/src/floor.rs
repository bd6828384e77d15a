//! The floor, a bare six-step tick by hand in C (`lab/floor/tick.c`), drives the simulated motor
//! (`lab/floor/turn.c`): the control tick is compared with it, and a tick that turns no motor is no fair
//! comparison.

use narx_core::motor::{Commutation, Commutations, PwmCommand, SampleMode, Samples, Step};
use narx_core::units::Duty;
use narx_report::figures::{Figure, Part};
use narx_report::{steps, target_directory};
use narx_sim::plant::{Plant, PlantConfig};
use narx_sim::presets::preset;
use std::f64::consts::TAU;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{ChildStdin, ChildStdout, Command, Stdio};

/// Control modes of the floor, as the program names them.
const MODES: [&str; 2] = ["hall", "sensorless"];

/// Motor that the floor drives: that of the rows `running`, on its 18 V.
const MOTOR: &str = "ec45-flat-50w-18v";
const SUPPLY: f64 = 18.0;
/// Its set-point, mechanical rpm.
const RPM: f64 = 1656.0;
/// Ticks before the measurement, and ticks of the measurement.
const SETTLED: u32 = 10_000;
const COUNTED: u32 = 10_000;

/// Result of a run of the floor with the motor.
#[derive(Clone, Copy, Debug)]
pub struct Turned {
    /// Set-point, rpm.
    pub target: f64,
    /// Mean speed over a second, rpm.
    pub rpm: f64,
}

/// Compiles the floor for this machine and lets it drive the simulated motor for two seconds. The motor
/// begins at the set-point's speed, because the floor cannot start it.
///
/// # Errors
/// Fails with the compiler's message, or with a line that is not a command.
pub fn turn(root: &Path, mode: &str) -> Result<Turned, String> {
    let program = target_directory(root).join("turn");
    let mut compiler = Command::new("cc");
    compiler
        .args(["-std=c99", "-O2"])
        .args(["-pedantic", "-Wall", "-Wextra", "-Werror"])
        .arg(root.join("lab/floor/turn.c"));
    steps::output(compiler.arg("-o").arg(&program))?;

    let motor = preset(MOTOR).ok_or("no such motor")?.motor;
    let (speed, poles) = (RPM * TAU / 60.0, f64::from(motor.pole_pairs));
    // The motor already turns, and enters the first step's sector.
    let volts = motor.torque_constant * speed;
    let config = PlantConfig { angle_deg: 30.0, speed, ..PlantConfig::new(motor, SUPPLY) };
    let mut plant = Plant::new(&config);
    let (millihertz, millivolt) = (RPM / 60.0 * poles * 1e3, volts * 1e3);
    let mut child = Command::new(&program)
        .args([mode, &format!("{millihertz:.0}"), &format!("{millivolt:.0}")])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| format!("{}: {error}", program.display()))?;
    let pipes = child.stdin.take().zip(child.stdout.take().map(BufReader::new));
    let (mut to, mut from) = pipes.ok_or("no pipes")?;
    let outcome = drive(&mut plant, &mut to, &mut from);
    // The program ends at the end of its input.
    drop(to);
    let status = child.wait().map_err(|error| error.to_string())?;
    let turned = outcome?;
    if status.success() { Ok(turned) } else { Err(format!("{}: {status}", program.display())) }
}

/// Largest difference from the set-point, %.
const TOLERANCE: f64 = 2.0;

/// Measures how far off its set-point the floor turns the motor.
pub(crate) fn part(root: &Path) -> Part {
    let mut part = Part::default();
    for mode in MODES {
        let off = turn(root, mode).map(|turned| 100.0 * (turned.rpm / turned.target - 1.0).abs());
        let name = format!("the floor drives the simulated motor, {mode}, off its set-point");
        part.figures
            .push(Figure::new(name, off.as_ref().copied().unwrap_or(f64::NAN), "%").at_most(TOLERANCE));
        part.failures.extend(off.err());
    }
    part
}

fn drive(
    plant: &mut Plant,
    to: &mut ChildStdin,
    from: &mut BufReader<ChildStdout>,
) -> Result<Turned, String> {
    let mut begun = plant.observe();
    for tick in 0..SETTLED + COUNTED {
        if tick == SETTLED {
            begun = plant.observe();
        }
        writeln!(to, "{}", line(&plant.sample())).map_err(|error| error.to_string())?;
        let mut answer = String::new();
        from.read_line(&mut answer).map_err(|error| error.to_string())?;
        let command = command(&answer).ok_or_else(|| format!("tick {tick}: not a command: {answer:?}"))?;
        plant.finish_period(&command);
    }
    let seen = plant.observe();
    let rpm = (seen.angle - begun.angle) / (seen.time - begun.time) * 60.0 / TAU;
    Ok(Turned { target: RPM, rpm })
}

/// Formats samples for the floor: its converter has our scales.
fn line(samples: &Samples) -> String {
    let Samples { bus_voltage, bus_current, phase_voltage: [a, b, c], hall, edges, .. } = samples;
    let (edge, at) = edges.last().map_or((0, 0), |edge| (1, edge.instant));
    format!("{bus_voltage} {bus_current} {a} {b} {c} {hall} {edge} {at}")
}

/// Parses `DUTY STEP AT NEXT` into a command for our bridge; it samples in the middle of the on-time, at the
/// period's boundary.
fn command(line: &str) -> Option<PwmCommand> {
    const STEPS: [Step; 7] = [Step::AB, Step::AC, Step::BC, Step::BA, Step::CA, Step::CB, Step::Coast];
    let words: Vec<u16> = line.split_whitespace().map_while(|word| word.parse().ok()).collect();
    let &[duty, step, at, next] = words.as_slice() else { return None };
    let (step, next) = (*STEPS.get(usize::from(step))?, *STEPS.get(usize::from(next))?);
    let mut commutations = Commutations::default();
    if next != step {
        commutations.push(Commutation { instant: at, step: next });
    }
    let duty = Duty::from_bits(duty);
    Some(PwmCommand {
        duty,
        step,
        commutations,
        sample_at: 0,
        sample_mode: SampleMode::OnTime,
        ..PwmCommand::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_floor_turns_the_simulated_motor() {
        for mode in MODES {
            let Turned { target, rpm } = turn(narx_report::root(), mode).unwrap();
            assert!((rpm / target - 1.0).abs() <= TOLERANCE / 100.0, "{mode}: {rpm} of {target} rpm");
        }
    }
}
