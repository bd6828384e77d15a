//! Invariants: events that may never happen, under any faults.

use narx_core::bus::Frame;
use narx_core::bus::narmotion::{FromDrive, MessageId, MessageKind};
use narx_core::dictionary::number;
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::{State, Step};
use narx_sim::bench::Bench;
use std::fmt;

/// Time after power-up in which no drive turns a motor, microseconds: boot takes half a second, and a start
/// needs requests that arrive after it.
const REST: u64 = 500_000;
/// Voltage above which over-voltage qualifies at once, V: no drive stays on. The energy of the windings then
/// still goes into the capacitor, because there is no brake chopper to take it.
const BUS_MAX: f64 = 62.0;
/// Factor on the windings' energy: as long as their current flows, the turning rotor's EMF adds half as much
/// again to the energy that they give to the capacitor.
const EMF_SHARE: f64 = 1.5;
/// Ticks for which an expired command, or a critical fault, may be seen together with a driving state: in the
/// report that contains it, not in the next tick.
const LATE: u32 = 1;
/// Ticks until a voltage above the limit is detected: by the next sample, or by the one after it if noise
/// hides it.
const HIGH: u32 = 2;

/// An invariant, or an event that must happen in peace, after the faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Never {
    /// Outside the driving states no switch is on.
    Bridge,
    /// No drive turns a motor shortly after power-up.
    Rest,
    /// No bridge stays on after the command has expired.
    Expired,
    /// No bridge stays on with a critical fault.
    Critical,
    /// No bridge stays on with the bus above its limit.
    Voltage,
    /// The state Fault has a cause.
    Cause,
    /// The parameter store survives, unless the whole flash is lost.
    Store,
    /// Physical quantities are finite numbers.
    Numbers,
    /// The bus rises no further than the windings' energy lifts it.
    Rise,
    /// Every frame of the drive is one of its protocol.
    Frames,
    /// In peace the drive reaches Standby.
    Standby,
    /// In peace the drive answers, and accepts its parameters.
    Answers,
    /// In peace the drive turns the motor, if an untouched drive does.
    Turns,
}

/// All invariants.
pub const NEVER: [Never; 13] = [
    Never::Bridge,
    Never::Rest,
    Never::Expired,
    Never::Critical,
    Never::Voltage,
    Never::Cause,
    Never::Store,
    Never::Numbers,
    Never::Rise,
    Never::Frames,
    Never::Standby,
    Never::Answers,
    Never::Turns,
];

impl Never {
    /// Name in a summary.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bridge => "outside the driving states the bridge is off",
            Self::Rest => "no motor turns within 0.5 s of power-up",
            Self::Expired => "no bridge stays on when the command has expired",
            Self::Critical => "no bridge stays on with a critical fault",
            Self::Voltage => "no bridge stays on above 62 V, as the drive reads them",
            Self::Cause => "Fault has a critical fault as its cause",
            Self::Store => "the parameter store is never broken, as long as its flash is there",
            Self::Numbers => "the simulated motor stays within the numbers",
            Self::Rise => "the bus rises no further than the windings' energy lifts it",
            Self::Frames => "every frame of the drive is one that its protocol knows",
            Self::Standby => "all mended, it gets to Standby",
            Self::Answers => "all mended, it answers every request and takes every parameter",
            Self::Turns => "all mended, it turns the motor, if a drive to which nothing has happened does",
        }
    }

    /// Returns the error that the invariant was broken.
    pub(super) fn broken<T>(self, what: impl Into<String>) -> Checked<T> {
        Err((self, what.into()))
    }
}

/// Result of a step, or a broken invariant.
pub(super) type Checked<T = ()> = Result<T, (Never, String)>;

/// A broken invariant.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// Time, s of the world's time.
    pub time: f64,
    /// The invariant.
    pub never: Never,
    /// Description of the event.
    pub what: String,
}

impl fmt::Display for Broken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "at {:.4} s: {}", self.time, self.what)
    }
}

/// [`BUS_MAX`] as the drive measures it: an operator may have set an offset for its converter (parameter 14).
fn bus_max(bench: &Bench) -> f64 {
    BUS_MAX - f64::from(bench.node().parameters().raw(number::HV_VOLTAGE_OFFSET)) * 1e-3
}

/// Checks of one drive from power-up.
#[derive(Default)]
pub(super) struct Watch {
    ticks: u64,
    expired: u32,
    critical: u32,
    high: u32,
    /// The flash was lost; its content may be lost, too.
    lost: bool,
}

impl Watch {
    /// Begins anew after a power-up.
    pub(super) fn begin_anew(&mut self) {
        *self = Self { lost: self.lost, ..Self::default() };
    }

    /// Allows the store to be broken from now on.
    pub(super) const fn spare_store(&mut self) {
        self.lost = true;
    }

    /// Forbids the store to be broken from now on: everything is stored again.
    pub(super) const fn hold_store(&mut self) {
        self.lost = false;
    }

    /// Checks a tick. period: of the PWM, microseconds.
    pub(super) fn tick(&mut self, bench: &Bench, period: u64) -> Checked {
        self.ticks += 1;
        let (status, command) = (bench.status(), bench.command());
        let driving = status.state.is_driving();
        if !driving && (command.step != Step::Coast || command.commutations.iter().next().is_some()) {
            return Never::Bridge.broken(format!("the bridge is on in {}: {command:?}", status.state.name()));
        }
        if driving && self.ticks * period < REST {
            return Never::Rest.broken(format!("{} us after power-up it drives", self.ticks * period));
        }
        self.expired = if driving && status.command_expired { self.expired + 1 } else { 0 };
        self.critical = if driving && !status.critical.is_empty() { self.critical + 1 } else { 0 };
        if self.expired > LATE {
            return Never::Expired
                .broken(format!("it drives ({}) though the command has expired", status.state.name()));
        }
        if self.critical > LATE {
            return Never::Critical.broken(format!(
                "it drives ({}) with a critical fault: {:?}",
                status.state.name(),
                status.critical
            ));
        }
        let max = bus_max(bench);
        self.high = if driving && bench.plant().observe().bus_voltage > max { self.high + 1 } else { 0 };
        if self.high > HIGH {
            return Never::Voltage
                .broken(format!("it drives ({}) with the bus above {max:.1} V", status.state.name()));
        }
        if status.state == State::Fault && status.critical.is_empty() {
            return Never::Cause.broken("it is in Fault without a critical fault");
        }
        if !self.lost && status.faults.intersects(FaultWord::STORE) {
            return Never::Store.broken(format!("the parameter store is broken: {:?}", status.faults));
        }
        Ok(())
    }

    /// Checks the physics; not in every tick, because the check is expensive and the quantities change
    /// slowly. `stored` is the largest energy that the windings have held, J.
    pub(super) fn physics(bench: &Bench, stored: f64, capacitance: f64) -> Checked {
        let seen = bench.plant().observe();
        let [a, b, c] = seen.current;
        if !(a + b + c + seen.speed + seen.bus_voltage + seen.angle + seen.winding_temperature).is_finite() {
            return Never::Numbers.broken(format!("physics has left the numbers: {seen:?}"));
        }
        // The supply may be above the drive's limit.
        let max = bus_max(bench).max(BUS_MAX);
        let top = (max * max + 2.0 * EMF_SHARE * stored / capacitance).sqrt();
        if seen.bus_voltage > top {
            return Never::Rise.broken(format!(
                "the bus has risen to {:.1} V; the windings can lift it to {top:.1} V",
                seen.bus_voltage
            ));
        }
        Ok(())
    }

    /// Checks a frame of the drive.
    pub(super) fn frame(frame: &Frame, address: u8) -> Checked {
        let Ok(id) = MessageId::of(frame) else { return Ok(()) };
        if id.source != address || id.kind != MessageKind::SlaveTx {
            return Ok(());
        }
        match FromDrive::decode(frame) {
            Ok(_) => Ok(()),
            Err(error) => Never::Frames.broken(format!("{frame:?} of the drive: {error:?}")),
        }
    }
}
