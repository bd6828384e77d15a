//! A drive with scripted samples.

use crate::rotor::ScriptedRotor;
use narx_core::motor::{
    Coefficients, Command, Drive, Event, FrontEnd, PwmCommand, RunRequest, Samples, State, Status,
};
use narx_core::units::ElectricalSpeed;

/// Boot time in ticks, 0.5 s.
pub(crate) const BOOT: u64 = 5_000;

/// A drive, its rotor, and samples that the script may change before a step.
pub(crate) struct Scripted {
    pub drive: Drive,
    pub rotor: ScriptedRotor,
    pub samples: Samples,
    pub request: RunRequest,
    /// Set-point, electrical rev/s.
    pub speed: i32,
    pub status: Status,
    /// Bus current at a blocked rotor for a duty of 1, A; it is proportional to the square of the duty.
    pub blocked_current: f64,
    /// Number of ticks so far.
    pub ticks: u64,
    /// Second drive for comparison; see [`watch`](Self::watch).
    watched: Option<Drive>,
}

/// Converter code of a bus voltage.
pub(crate) fn bus_code(volts: f64) -> u16 {
    (volts * 1e6 / FrontEnd::NARX.bus_voltage.micro_per_code as f64).round() as u16
}

/// Converter code of a bus current.
pub(crate) fn current_code(amperes: f64) -> u16 {
    (2048.0 + amperes * 1e6 / FrontEnd::NARX.bus_current.micro_per_code as f64).round() as u16
}

impl Scripted {
    /// A drive at power-up: 48 V, no current, Standby requested; the first tick has number `first`.
    pub(crate) fn new(coefficients: Coefficients, rotor: ScriptedRotor, first: u64) -> Self {
        let samples = Samples {
            tick: first,
            bus_voltage: bus_code(48.0),
            bus_current: current_code(0.0),
            ..Samples::default()
        };
        let drive = Drive::new(coefficients);
        let (request, speed) = (RunRequest::Standby, 100);
        Self {
            drive,
            rotor,
            samples,
            request,
            speed,
            status: Status::default(),
            blocked_current: 0.0,
            ticks: 0,
            watched: None,
        }
    }

    /// Present request, as a master repeats it.
    pub(crate) fn command(&self) -> Event {
        Event::Command(Command { request: self.request, speed: ElectricalSpeed::from_bits(self.speed << 16) })
    }

    /// Runs a tick: the master sends every 50 ms, and `spoil` changes the samples last.
    pub(crate) fn tick(&mut self, spoil: impl FnOnce(&mut Samples)) -> PwmCommand {
        if self.ticks.is_multiple_of(500) {
            self.handle_event(self.command());
        }
        self.rotor.advance(&mut self.samples);
        let mut samples = self.samples.clone();
        spoil(&mut samples);
        let watched = self.watched.as_mut().map(|drive| {
            drive.wake();
            (drive.step(&samples), drive.poll_status())
        });
        let output = self.drive.step(&samples);
        let status = self.drive.poll_status();
        if let Some(expected) = watched {
            assert_eq!(expected, (output, status), "tick {}", samples.tick);
        }
        self.samples.tick = self.samples.tick.wrapping_add(1);
        self.ticks += 1;
        let duty = f64::from(output.duty.to_bits()) / 32_768.0;
        self.samples.bus_current = current_code(self.blocked_current * duty * duty);
        if let Some(status) = status {
            self.status = status;
        }
        output
    }

    /// Compares every tick from now on with a second drive that runs every station in every tick: both must
    /// answer alike.
    pub(crate) fn watch(&mut self) {
        self.watched = Some(self.drive.clone());
    }

    fn handle_event(&mut self, event: Event) {
        if let Some(drive) = &mut self.watched {
            drive.handle_event(event.clone());
        }
        self.drive.handle_event(event);
    }

    /// Boots into Standby.
    pub(crate) fn boot(&mut self) {
        for _ in 0..BOOT + 1 {
            self.tick(|_| {});
        }
        assert_eq!(self.drive.state(), State::Standby);
    }

    /// Sends a request now.
    pub(crate) fn ask(&mut self, request: RunRequest) {
        self.request = request;
        self.handle_event(self.command());
    }
}
