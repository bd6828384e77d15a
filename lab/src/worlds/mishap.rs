//! Mishaps: drawn here, carried out by the world.

use narx_core::bus::narmotion::DigitalOutputs;
use narx_core::bus::{Frame, Id};
use narx_core::dictionary::{Access, Dictionary, number};
use narx_core::master::{Download, Request, Service};
use narx_sim::flash::Tear;
use narx_sim::plant::{Injection, InjectionOptions, Phase};
use narx_sim::random::Random;

/// A kind of mishap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Kind {
    /// The operator commands the motor.
    Command,
    /// The operator makes another request.
    Request,
    /// The operator downloads something, or aborts a download.
    Download,
    /// The operator lets the drive measure its motor.
    Identify,
    /// The master is silent for a time.
    Silence,
    /// Another device sends frames that were not requested.
    Frames,
    /// A part fails.
    Break,
    /// A failed part is repaired.
    Mend,
    /// Load or supply changes.
    World,
    /// Frames on the bus are disturbed.
    Disturb,
    /// The master's cable is disconnected for a time.
    Unplug,
    /// The power fails, perhaps while the flash is being written.
    Cut,
    /// A bit of the log's memory flips.
    Flip,
    /// The flash is disconnected, comes back, or is replaced.
    Chip,
}

/// All kinds.
pub const KINDS: [Kind; 14] = [
    Kind::Command,
    Kind::Request,
    Kind::Download,
    Kind::Identify,
    Kind::Silence,
    Kind::Frames,
    Kind::Break,
    Kind::Mend,
    Kind::World,
    Kind::Disturb,
    Kind::Unplug,
    Kind::Cut,
    Kind::Flip,
    Kind::Chip,
];

impl Kind {
    /// Name in a summary.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Command => "commands",
            Self::Request => "requests",
            Self::Download => "downloads",
            Self::Identify => "identifications",
            Self::Silence => "silences",
            Self::Frames => "stray frames",
            Self::Break => "breaks",
            Self::Mend => "repairs",
            Self::World => "loads and supplies",
            Self::Disturb => "disturbances",
            Self::Unplug => "unplugged",
            Self::Cut => "power cuts",
            Self::Flip => "flipped bits",
            Self::Chip => "lost and new flashes",
        }
    }

    /// Relative frequency with which the kind is drawn.
    const fn weight(self) -> f64 {
        match self {
            Self::Command => 30.0,
            Self::Request => 20.0,
            Self::Break | Self::Frames => 6.0,
            Self::Mend => 8.0,
            Self::World | Self::Disturb => 4.0,
            Self::Download | Self::Silence => 3.0,
            Self::Unplug => 2.0,
            Self::Identify | Self::Cut | Self::Flip | Self::Chip => 1.0,
        }
    }
}

/// The next mishap.
#[derive(Clone, Debug)]
pub(super) enum Mishap {
    Start(f64),
    SetSpeed(f64),
    Stop,
    ShutDown,
    Request(Request),
    Download(Download),
    AbortDownload,
    /// With the hall sensors, or without.
    Identify(bool),
    /// Duration, s.
    Silence(f64),
    Frames(Vec<Frame>),
    Break(Injection),
    Mend(Option<Injection>),
    /// Share of the rated torque.
    Load(f64),
    /// Source resistance, ohm, and whether the source takes current back.
    Source(f64, bool),
    /// Number of frames, and the bit at which they are disturbed.
    Disturb(u32, u32),
    /// Duration, s.
    Unplug(f64),
    /// Steps of the flash from now, and the state in which the last one is left.
    Cut(u64, Tear),
    /// Position as a share of the log's part of the flash, and the bit.
    Flip(f64, u8),
    Chip(Chip),
}

/// Change of the flash.
#[derive(Clone, Copy, Debug)]
pub(super) enum Chip {
    /// It no longer answers: fault bit 26 from the next power-up on.
    Silent,
    /// It answers again.
    Back,
    /// Power fails, and a blank flash is there when it is back: fault bit 30.
    New,
}

impl Mishap {
    pub(super) const fn kind(&self) -> Kind {
        match self {
            Self::Start(_) | Self::SetSpeed(_) | Self::Stop | Self::ShutDown => Kind::Command,
            Self::Request(_) => Kind::Request,
            Self::Download(_) | Self::AbortDownload => Kind::Download,
            Self::Identify(_) => Kind::Identify,
            Self::Silence(_) => Kind::Silence,
            Self::Frames(_) => Kind::Frames,
            Self::Break(_) => Kind::Break,
            Self::Mend(_) => Kind::Mend,
            Self::Load(_) | Self::Source(..) => Kind::World,
            Self::Disturb(..) => Kind::Disturb,
            Self::Unplug(_) => Kind::Unplug,
            Self::Cut(..) => Kind::Cut,
            Self::Flip(..) => Kind::Flip,
            Self::Chip(_) => Kind::Chip,
        }
    }
}

/// Source of random mishaps.
#[derive(Clone)]
pub(super) struct Fate(pub(super) Random);

impl Fate {
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    pub(super) fn below(&mut self, count: usize) -> usize {
        self.between(0.0, count as f64) as usize
    }

    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.0.uniform() < share
    }

    fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    pub(super) fn draw(&mut self) -> Mishap {
        let sum: f64 = KINDS.iter().map(|kind| kind.weight()).sum();
        let mut left = self.between(0.0, sum);
        let kind = KINDS.into_iter().find(|kind| {
            left -= kind.weight();
            left < 0.0
        });
        match kind.unwrap_or(Kind::Command) {
            Kind::Command => self.command(),
            Kind::Request => Mishap::Request(self.request()),
            Kind::Download => self.download(),
            Kind::Identify => Mishap::Identify(self.chance(0.3)),
            Kind::Silence => Mishap::Silence(self.between(0.0, 0.6)),
            Kind::Frames => Mishap::Frames(self.frames()),
            Kind::Break => Mishap::Break(self.injection()),
            Kind::Mend => Mishap::Mend(if self.chance(0.5) { None } else { Some(self.injection()) }),
            Kind::World if self.chance(0.5) => Mishap::Load(self.between(0.0, 0.6)),
            Kind::World => Mishap::Source(self.between(0.0, 0.5), self.chance(0.5)),
            Kind::Disturb => Mishap::Disturb(self.between(1.0, 60.0) as u32, self.between(0.0, 120.0) as u32),
            Kind::Unplug => Mishap::Unplug(self.between(0.0, 1.0)),
            Kind::Cut => Mishap::Cut(
                self.between(0.0, 3000.0) as u64,
                self.one(&[Tear::Nothing, Tear::Partial, Tear::Garbage]),
            ),
            Kind::Flip => Mishap::Flip(self.0.uniform(), self.below(8) as u8),
            Kind::Chip => Mishap::Chip(self.one(&[Chip::Silent, Chip::Silent, Chip::Back, Chip::New])),
        }
    }

    fn command(&mut self) -> Mishap {
        match self.below(10) {
            0..=4 => Mishap::Start(self.between(-1.2, 1.2)),
            5..=6 => Mishap::SetSpeed(self.between(0.0, 1.2)),
            7..=8 => Mishap::Stop,
            _ => Mishap::ShutDown,
        }
    }

    fn request(&mut self) -> Request {
        match self.below(20) {
            0..=8 => self.write(),
            9..=10 => Request::Read { number: self.below(400) as u16 },
            11..=14 => Request::Run(self.one(&Service::ALL)),
            15 => Request::Reboot,
            16 => Request::RestoreFactory { serial: self.one(&[0, 1, 0xFFFF]) },
            17 => Request::DigitalOutputs(DigitalOutputs::default()),
            18 => Request::DisableHallSupply(self.chance(0.5)),
            _ => Request::TriggerScope,
        }
    }

    /// Draws a write of any parameter, mostly within its range. The addresses are left out: a change of them
    /// would disconnect the drive from its operator.
    fn write(&mut self) -> Request {
        let rows: Vec<_> = Dictionary::rows()
            .filter(|row| ![number::SLAVE_CAN_ADDRESS, number::MASTER_CAN_ADDRESS].contains(&row.number))
            .filter(|row| row.access != Access::ReadOnly || self.0.uniform() < 0.1)
            .collect();
        let row = rows[self.below(rows.len())];
        let raw = match self.below(8) {
            0 => self.0.bits() as i32 as i64,
            1 => row.min() - 1,
            2 => row.max() + 1,
            3 => row.min(),
            4 => row.max(),
            _ => self.between(row.min() as f64, row.max() as f64) as i64,
        };
        Request::Write { number: row.number, raw: raw as i32 }
    }

    fn download(&mut self) -> Mishap {
        match self.below(4) {
            0 => Mishap::Download(Download::Description),
            1 => Mishap::Download(Download::Scope { words: 1 + self.below(4096) as u32 }),
            2 => Mishap::Download(Download::Log {
                first: self.below(100) as u32,
                records: 1 + self.below(100) as u32,
            }),
            _ => Mishap::AbortDownload,
        }
    }

    /// Draws up to 50 frames: of other devices, of the master's address with any contents, of other
    /// addresses, remote ones.
    fn frames(&mut self) -> Vec<Frame> {
        let count = 1 + self.below(50);
        (0..count).filter_map(|_| self.frame()).collect()
    }

    fn frame(&mut self) -> Option<Frame> {
        let bits = self.0.bits();
        let bytes = self.0.bits().to_be_bytes();
        let id = match self.below(4) {
            // 0AAD5200h is the master's Data Set, 0AAD5400h its Data Request, to the drive with factory
            // addresses.
            0 => Id::extended(0x0AAD_5200 | (bits & 0x1FF) as u32)?,
            1 => Id::extended(0x0AAD_5400 | (bits & 0x1FF) as u32)?,
            // Any address but the drive's own: no bus has two devices with one address.
            2 => Id::extended((bits & 0x1FFF_FFFF) as u32).filter(|id| id.raw() >> 19 & 0xFF != 0xAA)?,
            _ => Id::standard((bits & 0x7FF) as u16)?,
        };
        let length = if self.chance(0.8) { 8 } else { self.below(9) };
        if self.chance(0.05) { Frame::remote(id, length as u8) } else { Frame::data(id, &bytes[..length]) }
    }

    /// Draws an injection. One more draw, or one more kind, renumbers the worlds: the same number then leads
    /// to another story.
    fn injection(&mut self) -> Injection {
        let phase = self.one(&Phase::ALL);
        let kind = self.one(&Injection::KINDS);
        let value = kind.value.map(|range| {
            let (low, high) = match kind.name {
                "ambient" => (-40.0, 200.0),
                "supply" => (5.0, 61.0),
                "leak" => (5.0, 200.0),
                "hall-glitches" => (0.0, 2000.0),
                "pressure" => (0.0, 3.3),
                _ => (range.min, range.max),
            };
            self.between(low, high)
        });
        let high = kind.high && self.chance(0.5);
        let drawn = kind.with(InjectionOptions { value, phase: Some(phase), high });
        drawn.unwrap_or_else(|error| panic!("injection {}: {error}", kind.name))
    }
}
