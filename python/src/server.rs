//! The virtual drive that other programs reach through slcan, for `narx bench`.

use crate::bench;
use crate::error::{self, Given};
use crate::motor::{Load, Motor};
use crate::notes;
use narx_host::serve::{Server as Host, Speed, call, tx_drivers};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Duration of [`Server::step`], and longest delay of Ctrl-C.
const SLICE: Duration = Duration::from_millis(100);

/// A drive on a bench, in step with the clock, to which clients connect over TCP or a pseudo-terminal.
#[pyclass(module = "narx._core", frozen)]
pub(crate) struct Server {
    host: Mutex<Host>,
    /// Devices on the bus, and limits of the drive, in words.
    #[pyo3(get)]
    notes: Vec<String>,
}

#[pymethods]
impl Server {
    /// Powers up a commissioned drive; arguments up to seed as those of `narx.Bench`. tx_drivers: node-ids
    /// with commas between, ":dual" behind those with two channels. speed: simulated over real time; 0 is as
    /// fast as possible. seconds: simulated time after which it ends.
    #[new]
    #[pyo3(signature = (motor, supply_voltage=Given::Real(48.0), load=None, mode=Given::word("sensorless"), parameters=None,
                        ambient=Given::Real(25.0), seed=Given::Whole(1), pwm_rate=Given::Whole(10_000), tx_drivers=None, speed=Given::Real(1.0),
                        seconds=None))]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn new(
        motor: &Motor,
        supply_voltage: Given,
        load: Option<&Load>,
        mode: Given,
        parameters: Option<&Bound<'_, PyAny>>,
        ambient: Given,
        seed: Given,
        pwm_rate: Given,
        tx_drivers: Option<&str>,
        speed: Given,
        seconds: Option<Given>,
    ) -> PyResult<Self> {
        let mut config =
            bench::config(motor, supply_voltage, load, mode, parameters, ambient, seed, pwm_rate)?;
        config.trace = false;
        let (mut bench, commissioning) = config.power_up().map_err(error::parameter)?;
        let mut notes = notes::notes(&commissioning);
        if let Some(list) = tx_drivers {
            let refused = |allowed| error::parameter(format!("tx_drivers {list}: {allowed}"));
            for driver in tx_drivers::parse(list).map_err(refused)? {
                bench.add_tx_driver(&driver).map_err(error::parameter)?;
                notes.push(tx_drivers::title(&driver));
            }
        }
        let allowed = format!("a number from {} to {}, or 0 for as fast as it can", Speed::MIN, Speed::MAX);
        let within = |speed| speed == 0.0 || (Speed::MIN..=Speed::MAX).contains(&speed);
        let speed = match error::number("speed", speed, "", &allowed, within)? {
            0.0 => Speed::Unbound,
            speed => Speed::Times(speed),
        };
        let seconds = seconds.map(|seconds| error::magnitude("seconds", seconds, "s")).transpose()?;
        let end = seconds.map_or(u64::MAX, |seconds| (seconds * 1e9) as u64);
        Ok(Self { host: Mutex::new(Host::new(bench, speed, end)), notes })
    }

    /// Accepts clients over TCP at "HOST:PORT", or at a port that only this machine reaches; port 0 is any
    /// free one. Returns python-can's channel.
    fn listen(&self, address: &str) -> PyResult<String> {
        let local = format!("127.0.0.1:{address}");
        let address = if address.contains(':') { address } else { &local };
        let refused = |reason: &dyn std::fmt::Display| error::parameter(format!("tcp {address}: {reason}"));
        let parsed =
            address.parse().map_err(|_| refused(&"must be a port, or HOST:PORT with a numeric host"))?;
        let address = self.host().listen(parsed).map_err(|error| refused(&error))?;
        Ok(format!("socket://{address}"))
    }

    /// Accepts clients over a pseudo-terminal, at `link` if one is given. Returns python-can's channel.
    #[pyo3(signature = (link=None))]
    fn open_terminal(&self, link: Option<PathBuf>) -> PyResult<String> {
        let opened = self.host().open_terminal(link.as_deref());
        let name = link.map_or_else(String::new, |link| format!(" {}", link.display()));
        opened
            .map(|path| path.display().to_string())
            .map_err(|error| error::parameter(format!("pty{name}: {error}")))
    }

    /// Runs for a tenth of a second of real time; false at the end.
    fn step(&self, py: Python<'_>) -> bool {
        py.detach(|| {
            let (mut host, begun) = (self.host(), Instant::now());
            while begun.elapsed() < SLICE {
                if !host.step() {
                    return false;
                }
            }
            true
        })
    }

    /// Returns messages for the user since the previous call: clients that have connected or disconnected,
    /// and every second the drive's state.
    fn take_news(&self) -> Vec<String> {
        self.host().take_news()
    }

    /// Returns the call that opens a channel in python-can.
    #[staticmethod]
    fn call(channel: &str) -> String {
        call(channel)
    }
}

impl Server {
    fn host(&self) -> std::sync::MutexGuard<'_, Host> {
        self.host.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
