//! Steps of a command: each named and timed, with the closing lines of the programs that it ran.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::fmt::Display;
use std::io::{self, BufRead, BufReader, PipeReader};
use std::path::Path;
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Closing lines of a step that succeeded, or the reason why it failed.
pub type Outcome = Result<Vec<String>, String>;

/// A step to run.
pub struct Step<'a> {
    name: &'static str,
    run: Box<dyn FnOnce() -> Outcome + Send + 'a>,
}

impl<'a> Step<'a> {
    /// Builds a step that runs `run`.
    pub fn new(name: &'static str, run: impl FnOnce() -> Outcome + Send + 'a) -> Self {
        Self { name, run: Box::new(run) }
    }

    /// Builds a step that runs a program in `directory`.
    pub fn command(directory: &'a Path, name: &'static str, program: &'a str, arguments: &'a [&str]) -> Self {
        Self::new(name, move || run(Command::new(program).args(arguments).current_dir(directory)))
    }
}

/// Ends a command of one step: prints its closing lines after an empty one, or the reason why it failed.
pub fn finish(outcome: Outcome) -> ExitCode {
    match outcome {
        Ok(lines) => {
            println!();
            lines.iter().for_each(|line| println!("{line}"));
            ExitCode::SUCCESS
        }
        Err(reason) => {
            eprintln!("{reason}");
            ExitCode::FAILURE
        }
    }
}

thread_local! {
    /// Output of the step that this thread runs, if other steps run beside it.
    static KEPT: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Shows a line of a step's output: at once, or at the step's end if other steps run beside it.
pub fn say(line: impl Display) {
    KEPT.with_borrow_mut(|kept| match kept {
        Some(kept) => {
            kept.push_str(&line.to_string());
            kept.push('\n');
        }
        None => println!("{line}"),
    });
}

/// Name, duration and outcome of a step that has run.
type Done = (&'static str, Duration, Outcome);

/// Runs all steps, goes on after one that fails, and ends with a table of their results.
pub fn run_all(steps: Vec<Step<'_>>) -> ExitCode {
    table(&run_one_by_one(steps))
}

/// Runs the steps of each group in their order, two groups side by side, and at the end the steps of `last`.
/// Output of steps that run side by side is shown when they end.
pub fn run_groups(groups: Vec<Vec<Step<'_>>>, last: Vec<Step<'_>>) -> ExitCode {
    let workers = if groups.len() > 1 { 2 } else { 1 };
    let waiting = Mutex::new(groups.into_iter().enumerate().collect::<VecDeque<_>>());
    let done = Mutex::new(Vec::new());
    let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).pop_front();
    let work = || {
        KEPT.set((workers > 1).then(String::new));
        while let Some((place, steps)) = next() {
            let results = run_one_by_one(steps);
            done.lock().unwrap_or_else(PoisonError::into_inner).push((place, results));
        }
        KEPT.set(None);
    };
    thread::scope(|scope| {
        for _ in 1..workers {
            scope.spawn(work);
        }
        work();
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(place, _)| *place);
    let mut results: Vec<Done> = done.into_iter().flat_map(|(_, results)| results).collect();
    results.extend(run_one_by_one(last));
    table(&results)
}

fn run_one_by_one(steps: Vec<Step<'_>>) -> Vec<Done> {
    let one = |step: Step<'_>| {
        say(format_args!("\n== {}", step.name));
        let start = Instant::now();
        let outcome = (step.run)();
        if let Err(reason) = &outcome {
            say(reason);
        }
        // One call: output of other steps stays apart.
        if let Some(kept) = KEPT.with_borrow_mut(|kept| kept.as_mut().map(std::mem::take)) {
            print!("{kept}");
        }
        (step.name, start.elapsed(), outcome)
    };
    steps.into_iter().map(one).collect()
}

/// Prints the results; returns success if no step has failed.
fn table(results: &[Done]) -> ExitCode {
    println!();
    for (name, time, outcome) in results {
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
///
/// # Errors
/// Fails if the program does not start, or fails.
pub fn run(command: &mut Command) -> Outcome {
    let mut closing = Vec::new();
    let mut suite = String::new();
    watch(command, |line| {
        let trimmed = line.trim_start();
        if let Some(name) = trimmed.strip_prefix("Running ").or(trimmed.strip_prefix("Doc-tests ")) {
            name.split(" (").next().unwrap_or(name).clone_into(&mut suite);
        } else if line.starts_with("test result:") && !line.contains(" 0 passed; 0 failed; 0 ignored") {
            closing.push(format!("{suite}: {line}"));
        } else if line.contains(" passed, ") && line.ends_with(" failed") {
            closing.push(line.to_owned());
        } else if line.starts_with("==") && line.contains(" in ") {
            closing.push(line.trim_matches(['=', ' ']).to_owned());
        } else if line.starts_with("# pass ") {
            closing.push(line.trim_start_matches("# ").to_owned());
        }
    })?;
    Ok(closing)
}

/// Runs a program, shows its output, and gives each line of it to `see`.
///
/// # Errors
/// Fails if the program does not start, or fails.
pub fn watch(command: &mut Command, mut see: impl FnMut(&str)) -> Result<(), String> {
    let program = command.get_program().display().to_string();
    let (mut child, output) = start(command).map_err(|error| format!("{program} did not start: {error}"))?;
    for line in BufReader::new(output).lines().map_while(Result::ok) {
        say(&line);
        see(&line);
    }
    let status = child.wait().map_err(|error| format!("{program}: {error}"))?;
    let arguments: Vec<_> = command.get_args().map(|argument| argument.to_string_lossy()).collect();
    if status.success() { Ok(()) } else { Err(format!("{status}: {program} {}", arguments.join(" "))) }
}

/// Starts a program with both of its outputs in one pipe, so that lines stay in order.
fn start(command: &mut Command) -> io::Result<(Child, PipeReader)> {
    let (reader, writer) = io::pipe()?;
    let child = command.stdout(writer.try_clone()?).stderr(writer).spawn();
    // The command would hold its ends of the pipe open, and reading would never end.
    command.stdout(Stdio::null()).stderr(Stdio::null());
    Ok((child?, reader))
}

/// Runs a program; returns its output.
///
/// # Errors
/// Fails if the program does not start, or fails.
pub fn output(command: &mut Command) -> Result<String, String> {
    let program = command.get_program().display().to_string();
    let output = command.output().map_err(|error| format!("{program}: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("{program}: {}: {}", output.status, String::from_utf8_lossy(&output.stderr)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Steps of a group keep their order, two groups run at a time, and the last steps come after all.
    #[test]
    fn groups_run_side_by_side() {
        let (running, most, ended) = (AtomicUsize::new(0), AtomicUsize::new(0), AtomicUsize::new(0));
        let order = Mutex::new(Vec::new());
        let (running, most, ended, order) = (&running, &most, &ended, &order);
        let step = |group: usize, place: usize| {
            Step::new("step", move || {
                most.fetch_max(running.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                order.lock().unwrap().push((group, place));
                thread::yield_now();
                running.fetch_sub(1, Ordering::SeqCst);
                ended.fetch_add(1, Ordering::SeqCst);
                if group == 1 { Err("no".into()) } else { Ok(Vec::new()) }
            })
        };
        let groups = (0..5).map(|group| (0..4).map(|place| step(group, place)).collect()).collect();
        let last = Step::new("last", move || {
            assert_eq!(ended.load(Ordering::SeqCst), 20);
            Ok(Vec::new())
        });
        assert_eq!(run_groups(groups, vec![last]), ExitCode::FAILURE);
        assert!(most.load(Ordering::SeqCst) <= 2);
        let order = order.lock().unwrap();
        for group in 0..5 {
            let places: Vec<usize> =
                order.iter().filter(|(of, _)| *of == group).map(|(_, place)| *place).collect();
            assert_eq!(places, [0, 1, 2, 3]);
        }
    }
}
