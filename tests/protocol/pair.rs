//! A master and a node that exchange frames, shared by the master suites.

use crate::bench::Bench;
use narx_core::bus::Frame;
use narx_core::bus::narmotion::{Addresses, FromDrive, ToDrive};
use narx_core::dictionary::{Parameters, number};
use narx_core::master::{Answer, Config, Master, Request};
use std::collections::VecDeque;

/// Control tick, us.
pub(crate) const TICK: u64 = 100;

/// Delays of the copies of a frame, us. None is a loss, two are a duplicate.
pub(crate) type Fate = Vec<u64>;

/// A master, a node in Standby, and the line between them.
pub(crate) struct Pair {
    pub(crate) master: Master,
    pub(crate) bench: Bench,
    /// Present time, us.
    pub(crate) now: u64,
    /// Fates of the next frames in either direction; later frames arrive at the next tick.
    pub(crate) fates: VecDeque<Fate>,
    /// True if frames may overtake each other.
    pub(crate) disorderly: bool,
    /// Messages of the master with their times.
    pub(crate) sent: Vec<(u64, ToDrive)>,
    to_drive: Vec<(u64, Frame)>,
    from_drive: Vec<(u64, Frame)>,
}

impl Pair {
    pub(crate) fn new(config: Config) -> Self {
        Self::with_parameters(config, Parameters::new())
    }

    pub(crate) fn with_parameters(config: Config, parameters: Parameters) -> Self {
        Self {
            master: Master::new(config),
            bench: Bench::with_parameters(parameters),
            now: 0,
            fates: VecDeque::new(),
            disorderly: false,
            sent: Vec::new(),
            to_drive: Vec::new(),
            from_drive: Vec::new(),
        }
    }

    /// A pair whose master requests nothing by itself but the exact state.
    pub(crate) fn quiet() -> Self {
        Self::new(Config { read_parameters: false, ..Config::default() })
    }

    /// Runs one tick.
    pub(crate) fn step(&mut self) {
        self.now += TICK;
        let now = self.now;
        for frame in arrived(&mut self.from_drive, now) {
            self.master.handle_frame(&frame, now);
        }
        for frame in arrived(&mut self.to_drive, now) {
            self.bench.node.handle_frame(&frame);
        }
        self.bench.node.poll(now / TICK);
        while let Some(frame) = self.bench.node.poll_frame() {
            let fate = self.fates.pop_front();
            send(&mut self.from_drive, fate, now, frame, self.disorderly);
        }
        let mut frames = 0;
        while let Some(frame) = self.master.poll_frame(now) {
            self.sent.push((now, ToDrive::decode(&frame).expect("the master's own frame").1));
            let fate = self.fates.pop_front();
            send(&mut self.to_drive, fate, now, frame, self.disorderly);
            frames += 1;
            assert!(
                frames <= 4,
                "set-point, request word, a message without an answer and one with an answer"
            );
        }
    }

    pub(crate) fn run(&mut self, milliseconds: u64) {
        (0..milliseconds * 1000 / TICK).for_each(|_| self.step());
    }

    /// Makes a request, and waits for the answer.
    pub(crate) fn ask(&mut self, request: Request) -> Answer {
        self.master.request(request).expect("there is room");
        self.answer()
    }

    /// Waits for an answer.
    pub(crate) fn answer(&mut self) -> Answer {
        for _ in 0..100_000 {
            if let Some(answer) = self.master.poll_answer() {
                return answer;
            }
            self.step();
        }
        panic!("every request is answered in time");
    }

    /// Messages of the master since the last call that `wanted` selects.
    pub(crate) fn take_sent(&mut self, wanted: impl Fn(&ToDrive) -> bool) -> Vec<ToDrive> {
        self.sent.drain(..).map(|(_, message)| message).filter(wanted).collect()
    }
}

/// Gives a frame its fate.
fn send(line: &mut Vec<(u64, Frame)>, fate: Option<Fate>, now: u64, frame: Frame, disorderly: bool) {
    for delay in fate.unwrap_or_else(|| vec![0]) {
        let last = line.iter().map(|(at, _)| *at).max().filter(|_| !disorderly);
        line.push(((now + delay).max(last.unwrap_or(0)), frame));
    }
}

/// Frames that have arrived by `now`, in the order of arrival.
fn arrived(line: &mut Vec<(u64, Frame)>, now: u64) -> Vec<Frame> {
    let mut frames: Vec<(u64, Frame)> = line.extract_if(.., |(at, _)| *at <= now).collect();
    frames.sort_by_key(|(at, _)| *at);
    frames.into_iter().map(|(_, frame)| frame).collect()
}

/// A frame of the drive.
pub(crate) fn said(message: FromDrive) -> Frame {
    message.encode(Addresses::FACTORY)
}

/// Returns whether a message is a set-point or a request word.
pub(crate) fn is_command(message: &ToDrive) -> bool {
    matches!(message, ToDrive::MotorCommand { .. } | ToDrive::RequestWord(_))
}

/// Returns whether a message is neither a command nor the request for the exact state.
pub(crate) fn is_request(message: &ToDrive) -> bool {
    !is_command(message) && *message != ToDrive::RequestParameter { number: number::DRIVE_STATE }
}
