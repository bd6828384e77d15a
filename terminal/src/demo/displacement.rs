//! TX-Drivers of a demonstration: their masters configure, start and read them over the bus, as an engineer's
//! program would.

use narx_core::bus::Frame;
use narx_core::bus::eddycan::{Channels, Layout, NmtCommand, NodeId};
use narx_core::eddycan::Entry;
use narx_core::master::eddycan::{Config, Request, TxMaster};
use narx_sim::bench::Bench;
use narx_sim::sensor::{EddyCurrentConfig, Target};
use narx_sim::trace::{Signal, Trace};
use narx_sim::tx_driver::{AddError, TxDriverConfig};
use std::f64::consts::TAU;
use std::fmt;

const LAYOUT: Layout = Layout { channels: Channels::Single, encoder: false };
/// Measuring range, mm.
const RANGE: f64 = 2.0;
/// Index of the edge frequency of 1 kHz (Table 9).
const FILTER_1_KHZ: u32 = 3;
/// Update time with which the drivers take half of the bus (section 3.3.2).
const HALF_LOAD: u32 = 65_535;
/// Largest number of frames in the host's queue: frames of the drive's master shall not wait behind more.
const IN_CONTROLLER: usize = 2;
/// Number of drivers whose figures are printed one by one.
const TOLD: usize = 8;

/// All TX-Drivers of a demonstration.
pub(super) struct Displacement {
    stations: Vec<Station>,
    /// One row per tick: the last position of each driver, NaN before its first one.
    trace: Trace,
}

struct Station {
    node: NodeId,
    master: TxMaster,
    progress: Progress,
    samples: Vec<Sample>,
}

#[derive(Clone, Copy, PartialEq)]
enum Progress {
    /// Its boot-up message has not arrived.
    Waiting,
    /// Writes are under way.
    Configuring(usize),
    Started,
}

/// A position that was received over the bus.
#[derive(Clone, Copy)]
struct Sample {
    time_ns: u64,
    /// Position of the shaft at that time, revolutions.
    turns: f64,
    millimetres: f64,
}

impl Displacement {
    /// Powers up `count` drivers with the node-ids 1 to `count`. They alternate: one watches the shaft's
    /// surface, each a quarter further around, the next the disc on its end.
    pub(super) fn new(bench: &mut Bench, count: u8) -> Result<Self, AddError> {
        let nodes = (1..=count).filter_map(NodeId::new);
        let mut stations = Vec::new();
        for (place, node) in nodes.enumerate() {
            let target = match place % 2 {
                0 => Target::surface(RANGE / 2.0, 90.0 * (place / 2) as f64),
                _ => Target::face(RANGE / 2.0),
            };
            let mut config = TxDriverConfig::new(node);
            config.sensors = [EddyCurrentConfig::new(RANGE, target); 2];
            bench.add_tx_driver(&config)?;
            let master = TxMaster::new(Config::new(node, LAYOUT));
            stations.push(Station { node, master, progress: Progress::Waiting, samples: Vec::new() });
        }
        let signals: Vec<Signal> = (1..=count)
            // Leaked: the names are needed as long as the program runs.
            .map(|node| Signal::single(format!("displacement_{node}").leak(), "mm"))
            .collect();
        Ok(Self { stations, trace: Trace::new(&signals) })
    }

    /// Sends the frames of the masters; called before a tick.
    pub(super) fn send(&mut self, bench: &mut Bench) {
        let count = self.stations.len() as u32;
        for station in &mut self.stations {
            station.advance(count);
            while bench.host_queued() < IN_CONTROLLER
                && let Some(frame) = station.master.poll_frame(bench.now_ns() / 1000)
            {
                // The queue was just checked for room.
                let _ = bench.send(frame);
            }
        }
    }

    /// Takes a frame that has passed on the bus.
    pub(super) fn receive(&mut self, frame: &Frame, time_ns: u64, bench: &Bench) {
        for station in &mut self.stations {
            station.receive(frame, time_ns, bench);
        }
    }

    /// Adds a row to the trace; called after a tick.
    pub(super) fn keep(&mut self) {
        let last = |station: &Station| station.samples.last().map_or(f64::NAN, |sample| sample.millimetres);
        let row: Vec<f64> = self.stations.iter().map(last).collect();
        // Cannot fail: there are as many values as signals.
        let _ = self.trace.push(&row);
    }

    pub(super) const fn trace(&self) -> &Trace {
        &self.trace
    }

    /// Figures of the time from `from` to `to`, s.
    pub(super) fn figures(&self, from: f64, to: f64) -> Figures {
        let range = (from * 1e9) as u64..(to * 1e9) as u64;
        let figure = |station: &Station| {
            let inside = |sample: &&Sample| range.contains(&sample.time_ns);
            let samples: Vec<Sample> = station.samples.iter().filter(inside).copied().collect();
            Figure::new(station, &samples, to - from)
        };
        Figures(self.stations.iter().map(figure).collect())
    }
}

impl Station {
    /// Configures the node when it is present, and starts it when everything is written.
    fn advance(&mut self, count: u32) {
        match self.progress {
            Progress::Waiting if self.master.report().boots > 0 => {
                let writes = [
                    (Entry::Filter1, FILTER_1_KHZ),
                    (Entry::NrOfNodes, count),
                    (Entry::UpdateTime, HALF_LOAD),
                ];
                for (entry, value) in writes {
                    // Cannot fail: three requests of the eight that fit.
                    let _ = self.master.request(Request::Write(entry, value));
                }
                self.progress = Progress::Configuring(writes.len());
            }
            Progress::Configuring(left) => {
                // A node that refuses is not started, and has no figures.
                let done = self.master.poll_answer().is_some_and(|answer| answer.result.is_ok());
                let left = left - usize::from(done);
                self.progress = Progress::Configuring(left);
                if left == 0 && self.master.command(NmtCommand::Start).is_ok() {
                    self.progress = Progress::Started;
                }
            }
            Progress::Waiting | Progress::Started => {}
        }
    }

    fn receive(&mut self, frame: &Frame, time_ns: u64, bench: &Bench) {
        let id = frame.id();
        if id.is_extended() || id.raw() & 0x7F != u32::from(self.node.raw()) {
            return;
        }
        let before = self.master.reading().map(|(_, _, time)| time);
        self.master.handle_frame(frame, time_ns / 1000);
        if let Some((reading, _, time)) = self.master.reading()
            && before != Some(time)
        {
            let [position, _] = reading.positions;
            let millimetres = position.picometres() as f64 * 1e-9;
            self.samples.push(Sample { time_ns, turns: bench.shaft().turns, millimetres });
        }
    }
}

/// Figures of the displacements for a test engineer.
pub(super) struct Figures(Vec<Figure>);

struct Figure {
    node: u8,
    /// Positions per second.
    rate: f64,
    /// Difference of highest and lowest position, um.
    peak_to_peak: f64,
    /// Amplitude of the component that repeats once a revolution, um; none without a whole revolution.
    once: Option<f64>,
}

impl Figure {
    fn new(station: &Station, samples: &[Sample], seconds: f64) -> Self {
        let (low, high) = samples.iter().fold((f64::MAX, f64::MIN), |(low, high), sample| {
            (low.min(sample.millimetres), high.max(sample.millimetres))
        });
        Self {
            node: station.node.raw(),
            rate: samples.len() as f64 / seconds,
            peak_to_peak: 1e3 * (high - low).max(0.0),
            once: once_per_revolution(samples).map(|amplitude| 1e3 * amplitude),
        }
    }
}

/// Amplitude of the harmonic of order 1, mm: least squares of a + b cos(angle) + c sin(angle), at any angles
/// of the positions.
fn once_per_revolution(samples: &[Sample]) -> Option<f64> {
    let turned = samples.last()?.turns - samples.first()?.turns;
    if turned.abs() < 1.0 {
        return None;
    }
    let column = |of: fn(&Sample) -> f64| -> Vec<f64> {
        let values: Vec<f64> = samples.iter().map(of).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.into_iter().map(|value| value - mean).collect()
    };
    let cosine = column(|sample| (TAU * sample.turns).cos());
    let sine = column(|sample| (TAU * sample.turns).sin());
    let place = column(|sample| sample.millimetres);
    let product = |one: &[f64], other: &[f64]| -> f64 { one.iter().zip(other).map(|(a, b)| a * b).sum() };
    let (cc, cs, ss) = (product(&cosine, &cosine), product(&cosine, &sine), product(&sine, &sine));
    let (cx, sx) = (product(&cosine, &place), product(&sine, &place));
    let determinant = cc * ss - cs * cs;
    (determinant > 0.0).then(|| ((cx * ss - sx * cs) / determinant).hypot((sx * cc - cx * cs) / determinant))
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let nodes = self.0.len();
        let slowest = self.0.iter().map(|figure| figure.rate).fold(f64::MAX, f64::min);
        write!(
            f,
            "TX-Drivers     {nodes:8}        half of the bus: {slowest:.0} positions a second of each"
        )?;
        for figure in self.0.iter().take(TOLD) {
            let Figure { node, peak_to_peak, .. } = figure;
            write!(
                f,
                "\ndisplacement_{node:<3}{peak_to_peak:7.1} um     peak to peak over the last quarter"
            )?;
            if let Some(once) = figure.once {
                write!(f, ", {once:.1} um once per revolution")?;
            }
        }
        if nodes > TOLD {
            write!(f, "\n               {:8}        more in run.csv", nodes - TOLD)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Arguments, Run, Settings};
    use super::*;

    /// The column has the positions of the log's frames, row by row up to the last. The drivers were
    /// configured and started over the bus. The figures match the targets: 20 um cos(angle) + 5 um cos(2
    /// angle), and 8 um cos(angle).
    #[test]
    fn columns_are_what_the_frames_say() {
        let words = ["--mode", "hall", "--rpm", "2000", "--tx-drivers", "2", "--seconds", "2"];
        let settings = Settings::new(&Arguments::read(&words).unwrap()).unwrap();
        let mut run = Run::new(&settings).unwrap();
        while run.session.bench().time() < settings.seconds {
            run.step();
        }
        for sent in [" 601#22032000FFFF0000", " 602#2202200002000000", " 000#0101", " 000#0102"] {
            assert_eq!(run.log.matches(sent).count(), 1, "{sent}");
        }
        let displacement = run.displacement.as_ref().unwrap();
        assert_eq!(displacement.trace().len(), run.session.bench().trace().len());
        for (node, column) in (1..).zip(displacement.trace().columns()) {
            let name = format!(" can0 18{node}#");
            // Time and position of each frame; a row has the last position that had arrived when its tick
            // ended.
            let mut frames = run.log.lines().filter_map(|line| {
                let (time, data) = line.strip_prefix('(')?.split_once(&name)?;
                let raw = u32::from_str_radix(data, 16).unwrap().swap_bytes() as i32;
                // Steps of drivers and bits of the bus are whole microseconds.
                let time: u64 = time.trim_end_matches(')').replace('.', "").parse().unwrap();
                Some((time, f64::from(raw) / 134_217_728.0))
            });
            let mut next = frames.next();
            let mut last = f64::NAN;
            for (row, found) in column.iter().enumerate() {
                let end = (row as u64 + 1) * 50;
                while let Some((_, position)) = next.filter(|(time, _)| *time <= end) {
                    last = position;
                    next = frames.next();
                }
                assert!(
                    found.is_nan() && last.is_nan() || (found - last).abs() < 1e-6,
                    "{row}: {found}, {last}"
                );
            }
            assert!((last - 1.0).abs() < 0.05, "{last}");
        }
        let Figures(figures) = displacement.figures(1.5, 2.0);
        for (figure, peak_to_peak, once) in [(&figures[0], 40.0, 20.0), (&figures[1], 16.0, 8.0)] {
            assert!((figure.rate - 1316.0).abs() < 4.0, "{}", figure.rate);
            // Noise of 0.1 um rms behind a filter of 1 kHz.
            assert!((figure.peak_to_peak - peak_to_peak).abs() < 0.5, "{}", figure.peak_to_peak);
            assert!((figure.once.unwrap() - once).abs() < 0.1, "{:?}", figure.once);
        }
    }

    fn walk(count: u32, turns_each: f64, second: f64) -> Vec<Sample> {
        let at = |k| {
            let turns = f64::from(k) * turns_each;
            let angle = TAU * turns;
            let millimetres = 1.0 + 0.02 * (angle + 0.4).cos() + second * (2.0 * angle).cos();
            Sample { time_ns: 0, turns, millimetres }
        };
        (0..count).map(at).collect()
    }

    /// A known amplitude beside a mean is found: in either direction, with few positions at odd angles, and
    /// beside a second harmonic over many revolutions.
    #[test]
    fn the_amplitude_of_one_harmonic() {
        for (count, turns_each, second, tolerance) in [
            (5370, 1e-3, 0.0, 1e-9),
            (5370, -1e-3, 0.0, 1e-9),
            (9, 1.37, 0.0, 1e-9),
            (83_000, 1e-3, 0.005, 1e-6),
        ] {
            let found = once_per_revolution(&walk(count, turns_each, second)).unwrap();
            assert!((found - 0.02).abs() < tolerance, "{count}: {found}");
        }
        assert_eq!(once_per_revolution(&walk(900, 1e-3, 0.0)), None);
        assert_eq!(once_per_revolution(&[]), None);
    }
}
