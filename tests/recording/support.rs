//! Arbitrary ticks, ticks like those of a turning drive, and files made without the recorder.

use crc::{CRC_32_ISO_HDLC, Crc};
use narx_core::motor::guard::fault::FaultWord;
use narx_core::motor::machine::event::{Command, Event, Health, RunRequest, SlowMeasurements};
use narx_core::motor::{CurrentMode, Edge, EdgeSource, Lines, PwmCommand, SampleMode, Samples};
use narx_core::recording::{BEHAVIOUR_VERSION, Header, LAYOUT_VERSION, Recorder, Tick};
use narx_core::units::{Celsius, ElectricalSpeed, Volts};
use narx_sim::recording::RecordingBuffer;
use proptest::prelude::*;

/// A finished recording of these ticks, with the default command as every output.
pub(crate) fn record(header: &Header<'_>, state: &[u8], ticks: &[Tick]) -> Vec<u8> {
    let mut recorder = Recorder::new(RecordingBuffer::default(), header, state).unwrap();
    for tick in ticks {
        recorder.record(tick.event.as_ref(), &tick.samples, &PwmCommand::default(), None).unwrap();
    }
    recorder.finish().unwrap().0
}

/// A file of chunks, by the description of the container alone, including check values.
pub(crate) fn container(chunks: &[(u8, &[u8])]) -> Vec<u8> {
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut checked = b"narxrec\n\x01".to_vec();
    let mut file = checked.clone();
    for (tag, payload) in chunks {
        let start = checked.len();
        checked.push(*tag);
        checked.extend((payload.len() as u16).to_le_bytes());
        checked.extend(*payload);
        file.extend(&checked[start..]);
        file.extend(crc.checksum(&checked).to_le_bytes());
    }
    file
}

/// Header payload of a drive recording with an empty label, of this version of narx.
pub(crate) const HEADER: [u8; 10] = {
    let [behaviour, layout] = [BEHAVIOUR_VERSION.to_le_bytes(), LAYOUT_VERSION.to_le_bytes()];
    [1, behaviour[0], behaviour[1], layout[0], layout[1], 0x10, 0x27, 0, 0, 0]
};

pub(crate) fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        (0..4u8, any::<i32>()).prop_map(|(request, speed)| {
            let request = match request {
                0 => RunRequest::Standby,
                1 => RunRequest::Drive,
                2 => RunRequest::Reverse,
                _ => RunRequest::Shutdown,
            };
            Event::Command(Command { request, speed: ElectricalSpeed::from_bits(speed) })
        }),
        Just(Event::CoefficientsRejected),
        (any::<i32>(), any::<i32>()).prop_map(|(temperature, pressure)| {
            Event::Slow(SlowMeasurements {
                temperature: Celsius::from_bits(temperature),
                pressure: Volts::from_bits(pressure),
            })
        }),
        (any::<u32>(), any::<bool>()).prop_map(|(bits, self_test_failed)| {
            Event::Health(Health { store_faults: FaultWord::from_bits_truncate(bits), self_test_failed })
        }),
        any::<bool>().prop_map(Event::CalibrateHall),
    ]
}

fn edge() -> impl Strategy<Value = Edge> {
    (any::<u16>(), any::<bool>(), any::<u8>()).prop_map(|(instant, hall, code)| {
        let source = if hall { EdgeSource::Hall } else { EdgeSource::Comparator };
        Edge { instant, source, code }
    })
}

/// Strategy of any samples; the tick number is mostly near a wrap.
pub(crate) fn samples() -> impl Strategy<Value = Samples> {
    let tick = prop_oneof![any::<u64>(), u64::MAX - 2..=u64::MAX, 0..3u64];
    let flags = (any::<bool>(), any::<bool>(), any::<u8>(), any::<u8>(), any::<u8>());
    let codes = (any::<[u16; 3]>(), any::<u16>(), any::<u16>(), any::<u16>());
    (tick, codes, flags, prop::collection::vec(edge(), 0..=4)).prop_map(
        |(tick, (phase_voltage, bus_voltage, bus_current, skew), flags, edges)| {
            let (on_time, phase_current, hall, edges_lost, lines) = flags;
            Samples {
                tick,
                phase_voltage,
                bus_voltage,
                bus_current,
                sample_mode: if on_time { SampleMode::OnTime } else { SampleMode::OffTime },
                current_mode: if phase_current { CurrentMode::OnTime } else { CurrentMode::Average },
                skew,
                hall,
                edges: edges.into_iter().collect(),
                edges_lost,
                lines: Lines::from_bits_retain(lines),
            }
        },
    )
}

pub(crate) fn tick() -> impl Strategy<Value = Tick> {
    (prop::option::of(event()), samples()).prop_map(|(event, samples)| Tick { event, samples })
}

/// Small reproducible noise.
pub(crate) struct Noise(pub u64);

impl Noise {
    /// Uniform in `-amplitude..=amplitude`.
    pub(crate) fn around(&mut self, amplitude: i32) -> i32 {
        // Constants of Knuth's MMIX generator.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % (2 * amplitude as u64 + 1)) as i32 - amplitude
    }
}

/// Ticks of a drive that turns: 12-bit codes with noise, a hall edge every seventh tick, and the phase
/// voltages of a sector each.
pub(crate) fn turning(ticks: u64, noise: &mut Noise) -> Vec<Tick> {
    (0..ticks)
        .map(|k| {
            let sector = (k / 7 % 6) as usize;
            let level = |phase: usize| [3_300, 3_300, 1_650, 40, 40, 1_650][(sector + 2 * phase) % 6];
            let hall = [0b101, 0b001, 0b011, 0b010, 0b110, 0b100][sector];
            let mut code = |mean: i32| (mean + noise.around(12)) as u16;
            let mut samples = Samples {
                tick: 1_000 + k,
                phase_voltage: [code(level(0)), code(level(1)), code(level(2))],
                bus_voltage: code(3_300),
                bus_current: code(2_100),
                hall,
                ..Samples::default()
            };
            if k % 7 == 0 {
                let edge = Edge { instant: (k * 7_919) as u16, source: EdgeSource::Hall, code: hall };
                samples.edges.push(edge).unwrap();
            }
            let event = (k % 100 == 0).then(|| Event::Slow(SlowMeasurements::default()));
            Tick { event, samples }
        })
        .collect()
}
