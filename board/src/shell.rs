//! Code that all boards share: the control interrupt and the background loop, around the device's two halves.

use crate::side::{BackgroundSide, TickSide};
use core::pin::pin;
use core::sync::atomic::{AtomicU8, Ordering};
use core::task::{Context, Waker};
use narx_core::device;
use narx_core::node::{Action, ResetCause, SelfTests};
use narx_core::storage::{Mailbox, Opened};

/// Slow inputs are read this often, ms.
pub const INPUTS_MS: u64 = 10;
/// Frames taken from the bus in one pass at most: more in an interval of 100 us do not fit any CAN bus.
const FRAMES_A_PASS: usize = 16;

/// Tasks that have made progress since the watchdog was last fed.
#[derive(Debug, Default)]
pub struct Progress(AtomicU8);

const CONTROL: u8 = 1 << 0;
const CAN: u8 = 1 << 1;
const BACKGROUND: u8 = 1 << 2;

impl Progress {
    /// No task has made progress yet.
    pub const fn new() -> Self {
        Self(AtomicU8::new(0))
    }

    fn note(&self, task: u8) {
        self.0.fetch_or(task, Ordering::Relaxed);
    }

    /// Returns whether every task has made progress; if so, forgets it, so that each has to make progress
    /// anew.
    fn take_complete(&self) -> bool {
        let complete = self.0.load(Ordering::Relaxed) == CONTROL | CAN | BACKGROUND;
        if complete {
            self.0.store(0, Ordering::Relaxed);
        }
        complete
    }
}

/// The control interrupt.
pub struct Control<'a, 'm, B> {
    tick: device::ControlTick<'a, 'm>,
    board: B,
    progress: &'a Progress,
}

impl<'a, 'm, B: TickSide> Control<'a, 'm, B> {
    /// The interrupt's half of a device on its side of the board.
    pub const fn new(tick: device::ControlTick<'a, 'm>, board: B, progress: &'a Progress) -> Self {
        Self { tick, board, progress }
    }

    /// The body of the interrupt: once every PWM period, after its samples.
    #[inline]
    pub fn interrupt(&mut self) {
        let Some(samples) = self.board.samples() else { return };
        let command = self.tick.step(&samples);
        self.board.apply(&command);
        self.progress.note(CONTROL);
    }
}

/// The background loop.
pub struct Background<'a, 'm, B> {
    device: device::Background<'a, 'm>,
    board: B,
    progress: &'a Progress,
    flash: Option<&'a Mailbox>,
    ticks_per_inputs: u64,
    inputs_due: u64,
    seen: Option<u64>,
    failed: SelfTests,
}

impl<'a, 'm, B: BackgroundSide> Background<'a, 'm, B> {
    /// The background's half of a device on its side of the board.
    pub fn new(mut device: device::Background<'a, 'm>, board: B, progress: &'a Progress) -> Self {
        let ticks_per_ms = u64::from(device.node().board().tick_rate / 1000).max(1);
        Self {
            device,
            board,
            progress,
            flash: None,
            ticks_per_inputs: INPUTS_MS * ticks_per_ms,
            inputs_due: 0,
            seen: None,
            failed: SelfTests::empty(),
        }
    }

    /// With a flash, which answered `opened`: requests go to the mailbox and reports come from there.
    #[must_use]
    pub fn with_flash(mut self, mailbox: &'a Mailbox, opened: &Opened) -> Self {
        self.attach_flash(mailbox, opened);
        self
    }

    /// As [`with_flash`](Self::with_flash), in place.
    pub fn attach_flash(&mut self, mailbox: &'a Mailbox, opened: &Opened) {
        self.device.node().attach_storage(opened);
        self.flash = Some(mailbox);
    }

    /// With the reason of the start, for whoever asks the node.
    #[must_use]
    pub fn with_reset_cause(mut self, cause: ResetCause) -> Self {
        self.device.node().handle_reset_cause(cause);
        self
    }

    /// Runs for ever.
    pub fn run(mut self) -> ! {
        loop {
            self.pass();
        }
    }

    /// Runs for ever, and gives the task that serves the flash a turn in every pass.
    pub fn run_with(mut self, task: impl Future) -> ! {
        let mut task = pin!(task);
        loop {
            self.pass();
            // A task without an end: whoever polls it in every pass needs no waker.
            let _ = task.as_mut().poll(&mut Context::from_waker(Waker::noop()));
        }
    }

    /// One pass: lets time pass, then serves frames, inputs, outputs, the node's actions and the watchdog.
    pub fn pass(&mut self) {
        self.board.wait();
        let now = self.board.now();
        self.watch_bus();
        self.receive();
        self.read_inputs(now);
        self.device.run(now);
        self.serve_flash();
        #[cfg(feature = "update")]
        self.serve_update();
        self.send();
        self.board.apply(self.device.node().outputs());
        self.board.rest(!self.device.node().status().state.is_driving());
        if let Some(Action::Reboot) = self.device.node().poll_action() {
            self.board.reboot();
        }
        // A loop whose time stands still is as good as hung.
        if self.seen.replace(now) != Some(now) {
            self.progress.note(BACKGROUND);
        }
        if self.progress.take_complete() {
            self.board.feed_watchdog();
        }
    }

    /// The board, to look at.
    pub const fn board(&self) -> &B {
        &self.board
    }

    fn watch_bus(&mut self) {
        let state = self.board.bus_state();
        if state.is_off() {
            self.board.discard_frames();
        }
        self.device.node().handle_bus_state(state);
    }

    fn receive(&mut self) {
        for _ in 0..FRAMES_A_PASS {
            let Some(frame) = self.board.receive() else { break };
            self.device.node().handle_frame(&frame);
        }
    }

    fn send(&mut self) {
        while self.board.is_ready_to_send()
            && let Some(frame) = self.device.node().poll_frame()
        {
            self.board.send(&frame);
        }
        while self.board.is_ready_for_bulk()
            && let Some(frame) = self.device.node().poll_bulk_frame()
        {
            self.board.send(&frame);
        }
        // A bus that takes nothing is no fault of the drive: frames wait or are dropped, and control goes on.
        self.progress.note(CAN);
    }

    fn serve_flash(&mut self) {
        let Some(mailbox) = self.flash else { return };
        if let Some(report) = mailbox.take_report() {
            self.device.node().handle_storage(report);
        }
        if let Some(request) = self.device.node().poll_storage() {
            mailbox.ask(request);
        }
    }

    #[cfg(feature = "update")]
    fn serve_update(&mut self) {
        if let Some(request) = self.device.node().poll_update() {
            let report = self.board.serve_update(&request);
            self.device.node().handle_update(report);
        }
    }

    fn read_inputs(&mut self, now: u64) {
        if now >= self.inputs_due {
            self.inputs_due = now.saturating_add(self.ticks_per_inputs);
            let inputs = self.board.slow_inputs();
            self.device.node().handle_inputs(inputs);
            let failed = self.board.self_test();
            if failed != self.failed {
                self.failed = failed;
                self.device.node().handle_self_tests(failed);
            }
        }
    }
}
