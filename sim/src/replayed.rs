//! A recording that runs again, as a table: what the drive was given, what it answered, and what it thought
//! meanwhile.

use crate::trace::{Signal, Trace};
use alloc::string::{String, ToString};
use narx_core::motor::signal::{DRIVE_SIGNALS, ShaftScale, Signal as DriveSignal};
use narx_core::motor::{Drive, Samples, Status};
use narx_core::recording::{Outputs, Player, Recording, ReplayError};

/// Columns of a replay. Those of a bench's trace that a drive alone knows have the same names; what it
/// measures is not what is, and its speeds are electrical, because a recording does not tell the pole pairs.
pub const SIGNALS: [Signal; 17] = [
    Signal::double("time", "s"),
    Signal::single("state", ""),
    Signal::single("duty", ""),
    Signal::single("hall", ""),
    Signal::single("step", ""),
    Signal::single("limiter", ""),
    Signal::single("crossing", ""),
    Signal::single("crossing_margin", "deg"),
    Signal::single("bus_voltage_measured", "V"),
    Signal::single("bus_current_measured", "A"),
    Signal::single("voltage_a_measured", "V"),
    Signal::single("voltage_b_measured", "V"),
    Signal::single("voltage_c_measured", "V"),
    Signal::single("electrical_setpoint", "rev/s"),
    Signal::single("electrical_speed_hall", "rev/s"),
    Signal::single("electrical_speed_sensorless", "rev/s"),
    Signal::double("faults", ""),
];

/// Result of a replay.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// A row for each tick.
    pub trace: Trace,
    /// Ticks that ran.
    pub ticks: u64,
    /// Digest of the outputs now.
    pub digest: u64,
    /// Digest of the outputs when they were recorded; `None` of a part.
    pub recorded_digest: Option<u64>,
    /// Outputs of the last tick, every field in raw bits.
    pub outputs: Option<String>,
    /// The recording's label.
    pub label: String,
    /// The version that recorded behaves as this one.
    pub same_behaviour: bool,
}

/// Runs a recording, or its first `until` ticks.
///
/// # Errors
/// It is damaged, or not one of this drive.
pub fn replayed(bytes: &[u8], until: Option<u64>) -> Result<Replayed, ReplayError> {
    let recording = Recording::open(bytes)?;
    let rate = f64::from(recording.header().tick_rate.max(1));
    let mut player = Player::<Drive>::new(&recording)?;
    let mut trace = Trace::new(&SIGNALS);
    let (mut ticks, mut last, mut status) = (0, None, None);
    while until.is_none_or(|until| ticks < until)
        && let Some((samples, outputs)) = player.step()?
    {
        status = outputs.status.or(status);
        // As many values as signals: both stand in this file.
        let _ = trace.push(&row(rate, &samples, &outputs, player.drive(), status.as_ref()));
        ticks += 1;
        last = Some(outputs);
    }
    let recorded_digest = match until {
        None => Some(recording.verify()?.digest),
        Some(_) => None,
    };
    Ok(Replayed {
        trace,
        ticks,
        digest: player.digest(),
        recorded_digest,
        outputs: last.map(|outputs| outputs.to_string()),
        label: recording.header().label.to_string(),
        same_behaviour: recording.same_behaviour(),
    })
}

fn row(
    rate: f64,
    samples: &Samples,
    outputs: &Outputs,
    drive: &Drive,
    status: Option<&Status>,
) -> [f64; SIGNALS.len()] {
    let (crossing, margin, _) = drive.crossing();
    let seen = |signal: DriveSignal| {
        let row = DRIVE_SIGNALS.iter().find(|row| row.signal == signal);
        let base = row.and_then(|row| row.base.rescaled(0)).unwrap_or_default();
        f64::from(drive.signal(signal, ShaftScale::default(), samples)) * base as f64 / 4096.0
    };
    // Reports come once a millisecond; none has come before the first one.
    let speed = |of: fn(&Status) -> i32| status.map_or(f64::NAN, |status| f64::from(of(status)) / 65_536.0);
    [
        // A row tells how its tick ends.
        (outputs.tick + 1) as f64 / rate,
        f64::from(drive.state() as u8),
        f64::from(outputs.command.duty.to_bits()) / 32_768.0,
        f64::from(samples.hall),
        f64::from(outputs.command.step as u8),
        f64::from(drive.limiter() as u8),
        f64::from(crossing as u8),
        f64::from(margin) * 360.0 / 65_536.0,
        seen(DriveSignal::BusVoltage),
        seen(DriveSignal::PeriodCurrent),
        seen(DriveSignal::TerminalA),
        seen(DriveSignal::TerminalB),
        seen(DriveSignal::TerminalC),
        speed(|status| status.setpoint.to_bits()),
        speed(|status| status.speed_hall.to_bits()),
        speed(|status| status.speed_sensorless.to_bits()),
        f64::from(drive.faults().bits()),
    ]
}
