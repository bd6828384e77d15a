//! Steps of a command: each named and timed, with the closing lines of the programs that it ran.

use std::io::{self, BufRead, BufReader, PipeReader};
use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::{Duration, Instant};

/// Closing lines of a step that succeeded, or the reason why it failed.
pub type Outcome = Result<Vec<String>, String>;

/// A step to run.
pub struct Step<'a> {
    name: &'static str,
    run: Box<dyn FnOnce() -> Outcome + 'a>,
}

impl<'a> Step<'a> {
    /// Builds a step that runs `run`.
    pub fn new(name: &'static str, run: impl FnOnce() -> Outcome + 'a) -> Self {
        Self { name, run: Box::new(run) }
    }

    /// Builds a step that runs a program in `directory`.
    pub fn command(directory: &'a Path, name: &'static str, program: &'a str, arguments: &'a [&str]) -> Self {
        Self::new(name, move || run(Command::new(program).args(arguments).current_dir(directory)))
    }
}

/// Ends a command of one step: prints its closing lines, or the reason why it failed.
pub fn finish(outcome: Outcome) -> ExitCode {
    match outcome {
        Ok(lines) => {
            lines.iter().for_each(|line| println!("{line}"));
            ExitCode::SUCCESS
        }
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

/// Runs all steps, goes on after one that fails, and ends with a table of their results.
pub fn run_all(steps: Vec<Step<'_>>) -> ExitCode {
    let mut results: Vec<(&str, Duration, Outcome)> = Vec::new();
    for step in steps {
        println!("\n== {}", step.name);
        let start = Instant::now();
        let outcome = (step.run)();
        if let Err(reason) = &outcome {
            println!("{reason}");
        }
        results.push((step.name, start.elapsed(), outcome));
    }
    println!();
    for (name, time, outcome) in &results {
        let verdict = if outcome.is_ok() { "ok" } else { "FAILED" };
        println!("{verdict:<7} {name:<17} {:>6.1} s", time.as_secs_f64());
        match outcome {
            Ok(lines) => lines.iter().for_each(|line| println!("          {line}")),
            Err(reason) => println!("          {reason}"),
        }
    }
    if results.iter().all(|(_, _, outcome)| outcome.is_ok()) { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs a program, shows its output, and keeps the lines in which test runners sum up.
pub fn run(command: &mut Command) -> Outcome {
    let program = command.get_program().display().to_string();
    let (mut child, output) = start(command).map_err(|error| format!("{program} did not start: {error}"))?;
    let mut closing = Vec::new();
    let mut suite = String::new();
    for line in BufReader::new(output).lines().map_while(Result::ok) {
        println!("{line}");
        let trimmed = line.trim_start();
        if let Some(name) = trimmed.strip_prefix("Running ").or(trimmed.strip_prefix("Doc-tests ")) {
            name.split(" (").next().unwrap_or(name).clone_into(&mut suite);
        } else if line.starts_with("test result:") && !line.contains(" 0 passed; 0 failed; 0 ignored") {
            closing.push(format!("{suite}: {line}"));
        } else if line.contains(" passed, ") && line.ends_with(" failed") {
            closing.push(line);
        } else if line.starts_with("==") && line.contains(" in ") {
            closing.push(line.trim_matches(['=', ' ']).to_owned());
        } else if line.starts_with("# pass ") {
            closing.push(line.trim_start_matches("# ").to_owned());
        }
    }
    let status = child.wait().map_err(|error| format!("{program}: {error}"))?;
    let arguments: Vec<_> = command.get_args().map(|argument| argument.to_string_lossy()).collect();
    if status.success() { Ok(closing) } else { Err(format!("{status}: {program} {}", arguments.join(" "))) }
}

/// Starts a program with both of its outputs in one pipe, so that lines stay in order.
fn start(command: &mut Command) -> io::Result<(Child, PipeReader)> {
    let (reader, writer) = io::pipe()?;
    let child = command.stdout(writer.try_clone()?).stderr(writer).spawn();
    // The command would hold its ends of the pipe open, and reading would never end.
    command.stdout(Stdio::null()).stderr(Stdio::null());
    Ok((child?, reader))
}
