//! A virtual drive alone on its bus, with several clients at the host's place; the compiled part of
//! `can.Bus(interface="narx")`.

use crate::bench;
use crate::error::{self, Given};
use crate::frame;
use crate::motor::{Load, Motor};
use crate::tx_driver;
use narx_core::bus::Frame;
use narx_sim::bench::Bench;
use narx_sim::can::Attachment;
use pyo3::prelude::*;
use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// Number of the clients' frames in the controller that they share: one on the bus, and one to follow it
/// without a gap.
const IN_CONTROLLER: usize = 2;
/// Number of frames that may wait for a place in the controller.
const WAITING: usize = 1024;

#[pyclass(module = "narx._core", frozen)]
pub(crate) struct VirtualBus(Mutex<World>);

struct World {
    bench: Bench,
    /// Waiting frames of the clients in the order in which they came.
    waiting: VecDeque<(u64, Frame)>,
    /// Clients whose frames are in the controller.
    sent: VecDeque<u64>,
    /// Further drives. Each has a bus of its own, on which every frame of the first one's is repeated.
    others: Vec<Other>,
    /// Waiting frames of the further drives, and those that are in the controller, with the drive.
    relayed: [VecDeque<(usize, Frame)>; 2],
}

/// A further drive on the bus.
struct Other {
    bench: Bench,
    /// Frames of the bus that it has yet to receive.
    inbox: VecDeque<Frame>,
}

/// A frame that has passed: time in s, the client that has sent it, identifier, extended, remote, data.
type Passed<'py> = (f64, Option<u64>, frame::Parts<'py>);

#[pymethods]
impl VirtualBus {
    /// Powers up a commissioned drive; arguments as those of `narx.Bench`. tx_drivers: node-ids of TX-Drivers
    /// of one channel beside it.
    #[new]
    #[pyo3(signature = (motor, supply_voltage=Given::Real(48.0), load=None, mode=Given::word("sensorless"), parameters=None,
                        ambient=Given::Real(25.0), seed=Given::Whole(1), pwm_rate=Given::Whole(10_000), tx_drivers=None))]
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
        tx_drivers: Option<Vec<Given>>,
    ) -> PyResult<Self> {
        let mut config =
            bench::config(motor, supply_voltage, load, mode, parameters, ambient, seed, pwm_rate)?;
        config.trace = false;
        let (bench, _) = config.power_up().map_err(error::parameter)?;
        let mut bench = bench.without_recording();
        for node_id in tx_drivers.unwrap_or_default() {
            let config = tx_driver::config(node_id, Given::Whole(1), Some(Given::Whole(4096)), 2.0.into())?;
            bench.add_tx_driver(&config).map_err(error::parameter)?;
        }
        Ok(Self(Mutex::new(World {
            bench,
            waiting: VecDeque::new(),
            sent: VecDeque::new(),
            others: Vec::new(),
            relayed: Default::default(),
        })))
    }

    /// Powers up a further drive on this bus, before time passes; arguments as those of `narx.Bench`.
    #[pyo3(signature = (motor, supply_voltage=Given::Real(48.0), load=None, mode=Given::word("sensorless"), parameters=None,
                        ambient=Given::Real(25.0), seed=Given::Whole(1), pwm_rate=Given::Whole(10_000)))]
    #[allow(clippy::too_many_arguments, reason = "Python calls it with names")]
    fn add_drive(
        &self,
        py: Python<'_>,
        motor: &Motor,
        supply_voltage: Given,
        load: Option<&Load>,
        mode: Given,
        parameters: Option<&Bound<'_, PyAny>>,
        ambient: Given,
        seed: Given,
        pwm_rate: Given,
    ) -> PyResult<()> {
        let mut config =
            bench::config(motor, supply_voltage, load, mode, parameters, ambient, seed, pwm_rate)?;
        config.trace = false;
        let (bench, _) = config.power_up().map_err(error::parameter)?;
        let other = Other { bench: bench.without_recording(), inbox: VecDeque::new() };
        self.with(py, |world| {
            if world.bench.now_ns() > 0 {
                return Err(error::refused(
                    "a further drive is powered up with the first one, before time passes",
                ));
            }
            world.bench.set_other(Attachment::Normal);
            world.others.push(other);
            Ok(())
        })
    }

    /// Time since power-up, s.
    #[getter]
    fn time(&self, py: Python<'_>) -> f64 {
        self.with(py, |world| world.bench.now_ns()) as f64 / 1e9
    }

    /// Queues a frame of a client; returns whether there was room.
    fn send(
        &self,
        py: Python<'_>,
        client: u64,
        id: u32,
        extended: bool,
        remote: bool,
        data: &[u8],
    ) -> PyResult<bool> {
        let frame = frame::new(id, extended, remote, data)?;
        Ok(self.with(py, |world| {
            let room = world.waiting.len() < WAITING;
            if room {
                world.waiting.push_back((client, frame));
            }
            room
        }))
    }

    /// Runs until simulated time is `until`, or until a frame has passed, if `until_frame`; returns the
    /// frames that have passed.
    fn advance<'py>(&self, py: Python<'py>, until: f64, until_frame: bool) -> Vec<Passed<'py>> {
        let until = (until * 1e9).round() as u64;
        let passed = self.with(py, |world| {
            let mut passed = Vec::new();
            while world.bench.now_ns() < until && (!until_frame || passed.is_empty()) {
                world.step(&mut passed);
            }
            passed
        });
        let parts = |(time, client, frame): (u64, Option<u64>, Frame)| {
            (time as f64 / 1e9, client, frame::parts(py, &frame))
        };
        passed.into_iter().map(parts).collect()
    }
}

impl VirtualBus {
    fn with<T: Send>(&self, py: Python<'_>, act: impl FnOnce(&mut World) -> T + Send) -> T {
        py.detach(|| act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

impl World {
    /// Runs one control tick.
    fn step(&mut self, passed: &mut Vec<(u64, Option<u64>, Frame)>) {
        while self.sent.len() < IN_CONTROLLER
            && let Some((place, _)) = self.waiting.iter().enumerate().min_by_key(|(_, (_, frame))| frame.id())
            && let Some((client, frame)) = self.waiting.remove(place)
        {
            // There is always room for two frames.
            if self.bench.send(frame).is_ok() {
                self.sent.push_back(client);
            }
        }
        let [waiting, sent] = &mut self.relayed;
        while sent.len() < IN_CONTROLLER
            && let Some(place) = first(waiting)
            && let Some((drive, frame)) = waiting.remove(place)
        {
            // There is always room for two frames.
            if self.bench.send_as_other(frame).is_ok() {
                sent.push_back((drive, frame));
            }
        }
        self.bench.step();
        // Frames for the host itself are dropped: its clients get all frames of the bus below.
        while self.bench.receive().is_some() {}
        while let Some(received) = self.bench.monitor() {
            let own = received.sender == self.bench.host();
            let client = if own { self.sent.pop_front() } else { None };
            self.repeat(&received.frame);
            passed.push((received.time_ns, client, received.frame));
        }
        self.step_others();
    }

    /// Repeats a frame on the buses of all further drives but that of its sender.
    fn repeat(&mut self, frame: &Frame) {
        let sent = &mut self.relayed[1];
        let place = sent.iter().position(|(_, relayed)| relayed == frame);
        let sender = place.and_then(|place| sent.remove(place)).map(|(drive, _)| drive);
        for (drive, other) in self.others.iter_mut().enumerate() {
            if sender != Some(drive) {
                other.inbox.push_back(*frame);
            }
        }
    }

    /// Runs the further drives up to the first one's time, and takes what they send.
    fn step_others(&mut self) {
        for (drive, Other { bench, inbox }) in self.others.iter_mut().enumerate() {
            while bench.now_ns() < self.bench.now_ns() {
                while bench.host_queued() < IN_CONTROLLER
                    && let Some(frame) = inbox.pop_front()
                {
                    // There is always room for two frames.
                    let _ = bench.send(frame);
                }
                bench.step();
                while bench.receive().is_some() {}
                while let Some(received) = bench.monitor() {
                    if received.sender != bench.host() {
                        self.relayed[0].push_back((drive, received.frame));
                    }
                }
            }
        }
    }
}

/// Returns the place of the waiting frame that wins the arbitration, the oldest of those with its identifier.
fn first(waiting: &VecDeque<(usize, Frame)>) -> Option<usize> {
    waiting.iter().enumerate().min_by_key(|(_, (_, frame))| frame.id()).map(|(place, _)| place)
}
