//! Experiments: a start and its figures, many of them on every core.

use crate::bench::{self, Run};
use crate::error::{self, Given};
use crate::master;
use crate::motor::{Load, Motor};
use crate::notes;
use narx_host::parallel;
use narx_sim::experiment::{FIGURES, Figures, Outcome, Value};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::Ordering;

/// A bench that powers up, gets a request for a speed and runs.
#[pyclass(module = "narx._core", frozen)]
pub(crate) struct Experiment {
    experiment: narx_sim::experiment::Experiment,
    /// Largest temperature that the winding may have, degrees Celsius.
    winding_max: f64,
}

#[pymethods]
impl Experiment {
    /// motor to seed are those of `narx.Bench`. rpm: set-point; without one the middle of the range of
    /// commissioning. seconds: from the Drive request to the end. fault to fault_high are those of
    /// `narx.Bench.inject`; fault_time: s after the request.
    #[new]
    #[pyo3(signature = (motor, supply_voltage=Given::Real(48.0), load=None, mode=Given::word("sensorless"), parameters=None,
                        ambient=Given::Real(25.0), seed=Given::Whole(1), pwm_rate=Given::Whole(10_000), rpm=None, seconds=Given::Real(2.0),
                        fault=None, fault_value=None, fault_phase=None, fault_high=false, fault_time=Given::Real(0.0)))]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn new(
        py: Python<'_>,
        motor: &Motor,
        supply_voltage: Given,
        load: Option<&Load>,
        mode: Given,
        parameters: Option<&Bound<'_, PyAny>>,
        ambient: Given,
        seed: Given,
        pwm_rate: Given,
        rpm: Option<Given>,
        seconds: Given,
        fault: Option<&str>,
        fault_value: Option<Given>,
        fault_phase: Option<Given>,
        fault_high: bool,
        fault_time: Given,
    ) -> PyResult<Self> {
        let session = bench::config(motor, supply_voltage, load, mode, parameters, ambient, seed, pwm_rate)?;
        session.commission().map_err(error::parameter)?;
        let fault_time = error::magnitude("fault_time", fault_time, "s")?;
        let injection = |name| bench::injection(py, name, fault_value, fault_phase, fault_high);
        let experiment = narx_sim::experiment::Experiment {
            session,
            rpm: rpm.map(master::rpm).transpose()?,
            seconds: error::magnitude("seconds", seconds, "s")?,
            fault: fault.map(injection).transpose()?.map(|injection| (injection, fault_time)),
        };
        Ok(Self { experiment, winding_max: motor.max_winding_temperature() })
    }

    /// Runs the experiment; returns columns by name, units by name and the recording, since power-up.
    fn run<'py>(&self, py: Python<'py>) -> PyResult<Run<'py>> {
        let mut interrupted = Ok(());
        let mut goes_on = || {
            interrupted = Python::attach(|py| py.check_signals());
            interrupted.is_ok()
        };
        let run = py.detach(|| self.experiment.run(&mut goes_on)).map_err(error::parameter)?;
        interrupted?;
        let left =
            run.map(|(_, mut session)| (session.bench_mut().take_trace(), session.bench().recording()));
        bench::run(py, left.ok_or_else(|| error::refused("the run was interrupted"))?)
    }
}

/// Set-point that the drive has accepted.
const ACCEPTED: (&str, &str) = ("accepted", "rpm");
/// Outcome of a motor that runs at another set-point than the requested one.
const CLAMPED: &str = "clamped";

/// Name and unit of every figure of an experiment.
#[pyfunction]
pub(crate) fn experiment_figures() -> Vec<(&'static str, &'static str)> {
    FIGURES.into_iter().chain([ACCEPTED]).collect()
}

/// Runs experiments on `threads` threads, or on every core. `tell` is called when each one ends, with its
/// index and its figures, or with the text of its error. Only figures are kept. An error of `tell`, or
/// Ctrl-C, ends the run.
#[pyfunction]
#[pyo3(signature = (experiments, tell, threads=None))]
pub(crate) fn run_experiments(
    py: Python<'_>,
    experiments: Vec<PyRef<'_, Experiment>>,
    tell: Bound<'_, PyAny>,
    threads: Option<usize>,
) -> PyResult<()> {
    let mut jobs: Vec<_> =
        experiments.iter().map(|given| (given.experiment.clone(), given.winding_max)).collect();
    jobs.iter_mut().for_each(|(job, _)| job.session.trace = false);
    let tell = tell.unbind();
    let threads = threads.unwrap_or_else(parallel::threads);
    let mut outcome = Ok(());
    py.detach(|| {
        parallel::for_each(
            &jobs,
            threads,
            |(job, winding_max), stop| {
                let run = || job.run(|| !stop.load(Ordering::Relaxed));
                // A panic of one experiment must not end the others.
                let run = catch_unwind(AssertUnwindSafe(run)).map_err(|_| "the simulation failed".into());
                let run = run.and_then(|run| run.map_err(|error| error.to_string()))?;
                Ok::<_, String>(run.map(|(figures, mut session)| {
                    let accepted = session.master().report().accepted_speed.map(|received| received.value);
                    let accepted = accepted.filter(|_| figures.attempts > 0);
                    let notes = notes::notes(session.commissioning()).into_iter();
                    let time = session.bench().time();
                    let notes = notes.chain(notes::winding(figures.winding_temperature, time, *winding_max));
                    (figures, accepted, job.rpm.is_some(), notes.collect::<Vec<_>>().join("; "))
                }))
            },
            |finished| {
                outcome = Python::attach(|py| {
                    match finished {
                        Some((index, Ok(Some((figures, accepted, requested, notes))))) => {
                            let figures = dictionary(py, &figures, accepted, requested)?;
                            figures.set_item("notes", notes)?;
                            drop(tell.call1(py, (index, figures))?)
                        }
                        Some((index, Err(reason))) => drop(tell.call1(py, (index, reason))?),
                        Some((_, Ok(None))) | None => {}
                    }
                    py.check_signals()
                });
                outcome.is_ok()
            },
        );
    });
    outcome
}

/// Returns the figures by name. accepted: set-point that the drive has accepted, rpm. requested: whether the
/// set-point is the user's.
fn dictionary<'py>(
    py: Python<'py>,
    figures: &Figures,
    accepted: Option<u16>,
    requested: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let values = PyDict::new(py);
    for ((name, _), value) in FIGURES.iter().zip(figures.values()) {
        match value {
            Value::Count(value) => values.set_item(name, value)?,
            Value::Number(value) => values.set_item(name, value)?,
            Value::Text(value) => values.set_item(name, value)?,
        }
    }
    let sign = figures.setpoint.signum();
    let accepted = accepted.map(|accepted| sign * i32::from(accepted));
    values.set_item(ACCEPTED.0, accepted)?;
    if requested
        && figures.outcome == Outcome::Running
        && accepted.is_some_and(|speed| speed != figures.setpoint)
    {
        values.set_item("outcome", CLAMPED)?;
    }
    Ok(values)
}
