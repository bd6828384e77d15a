//! The floor to which the control tick is compared: a bare six-step tick by hand in C (`xtask/floor/tick.c`),
//! counted on the emulated Cortex-M4F. It also drives the simulated motor (`xtask/floor/turn.c`), because a
//! tick that turns no motor is no fair comparison.

use crate::steps::Outcome;
use crate::{cross, driven, install, qemu};
use narx_core::motor::{Commutation, Commutations, PwmCommand, SampleMode, Samples, Step};
use narx_core::units::Duty;
use narx_sim::plant::{Plant, PlantConfig};
use narx_sim::presets::preset;
use std::f64::consts::TAU;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, ChildStdout, Command, Stdio};

/// Number of ticks that are counted: 2 s.
const TICKS: u32 = 20_000;

/// Version of the compiler; the figures hold for this version only.
///
/// # Errors
/// Fails if the compiler is missing and cannot be installed.
pub fn compiler_version() -> Result<String, String> {
    install::debian(&cross::PACKAGES)?;
    let version = driven::output(Command::new(cross::COMPILER).arg("-dumpfullversion"))?;
    Ok(version.trim().to_owned())
}

/// Runs both ticks of a motor that turns at `millihertz`, electrical. Returns a line `floor NAME TICKS TOTAL
/// WORST` for each, and one after `#` that describes its work.
///
/// # Errors
/// Fails with the message of compiler or emulator, or with the tick that does not do its work.
pub fn run(root: &Path, millihertz: u32) -> Result<String, String> {
    let program = compile(root)?;
    let arguments = [millihertz.to_string(), TICKS.to_string()];
    let mut command = qemu::counting(&program, &arguments);
    let output = command.output().map_err(|error| format!("{}: {error}", qemu::PROGRAM))?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        Ok(text)
    } else {
        Err(format!("xtask/floor/tick.c: {}\n{text}", output.status))
    }
}

fn compile(root: &Path) -> Result<PathBuf, String> {
    let program = install::target_directory(root).join("tick");
    let mut compiler = cross::compiler(root);
    compiler.args(["-std=c99", "-O3"]).args(cross::STRICT).arg(root.join("xtask/floor/tick.c"));
    driven::output(compiler.arg("-o").arg(&program)).map(|_| program)
}

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
    let program = install::target_directory(root).join("turn");
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-O2"]).args(cross::STRICT).arg(root.join("xtask/floor/turn.c"));
    driven::output(compiler.arg("-o").arg(&program))?;

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

/// Largest difference from the set-point, as a share of it.
const TOLERANCE: f64 = 0.02;

/// Checks that both ticks turn the motor at their set-point.
///
/// # Errors
/// Fails with the tick that does not.
pub fn check(root: &Path) -> Outcome {
    let one = |mode: &str| {
        let Turned { target, rpm } = turn(root, mode)?;
        let line = format!("{mode}: the floor turns the simulated motor at {rpm:.1} of {target:.0} rpm");
        if (rpm / target - 1.0).abs() <= TOLERANCE { Ok(line) } else { Err(line) }
    };
    driven::MODES.into_iter().map(one).collect()
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
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
        let lines = check(root).unwrap();
        assert_eq!(lines.len(), driven::MODES.len(), "{lines:?}");
    }
}
