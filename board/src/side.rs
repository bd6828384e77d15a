//! Interface between a board and the shell: one side for the control interrupt, one for the background.
//!
//! Two traits and two owners, because the interrupt strikes at any instant of the background.

#[cfg(feature = "update")]
use narx_core::bus::narmotion::update::UpdateCode;
use narx_core::bus::{BusState, Frame};
use narx_core::motor::{PwmCommand, Samples};
#[cfg(feature = "update")]
use narx_core::node::update;
use narx_core::node::{Outputs, SelfTests, SlowInputs};

/// The control interrupt's side.
pub trait TickSide {
    /// Returns the samples of this period; `None` if the interrupt came without a period.
    fn samples(&mut self) -> Option<Samples>;

    /// Puts the answer to these samples on the bridge and its timers.
    fn apply(&mut self, command: &PwmCommand);
}

/// The background's side.
pub trait BackgroundSide {
    /// Control ticks since power-up.
    fn now(&self) -> u64;

    /// Lets time pass: sleeps until an interrupt. A board whose motor is simulated turns it for a period.
    fn wait(&mut self);

    /// The next frame that has arrived.
    fn receive(&mut self) -> Option<Frame>;

    /// Returns whether a frame can be [sent](Self::send).
    fn is_ready_to_send(&self) -> bool;

    /// Returns whether a bulk frame can be [sent](Self::send): no more than one frame is in the controller,
    /// the one that is on the bus. More would delay what the drive has to say next.
    fn is_ready_for_bulk(&self) -> bool;

    /// Gives a frame to the CAN controller, which has just been seen to be ready.
    fn send(&mut self, frame: &Frame);

    /// Returns the state of the CAN controller. A controller that has gone bus-off comes back by itself as
    /// soon as ISO 11898-1 allows it.
    fn bus_state(&self) -> BusState;

    /// Takes back the frames that the CAN controller has not sent: the bus is gone, and they would be stale.
    fn discard_frames(&mut self);

    /// Reads what is measured besides the tick's samples.
    fn slow_inputs(&mut self) -> SlowInputs;

    /// Sets the digital lines and the supply of the hall sensors.
    fn apply(&mut self, outputs: Outputs);

    /// Tells the board whether the motor is at rest: `false` if the bridge may be needed at once; `true` if
    /// it is off, in Standby, Fault and before either. At rest a board stops what only a turning motor needs,
    /// as far as that is ready again before the next control tick has acted: comparators, amplifiers, a
    /// faster clock. Measuring goes on.
    fn rest(&mut self, _is_at_rest: bool) {}

    /// Does a piece of the tests that go on while the drive runs, about every 10 ms. All that have failed
    /// since power-up, those of boot included.
    fn self_test(&mut self) -> SelfTests {
        SelfTests::empty()
    }

    /// Does what the node asks for the slot of the bootloader, all of it before it returns: a page erased, a
    /// piece written. A board without one is not asked.
    #[cfg(feature = "update")]
    fn serve_update(&mut self, _request: &update::SlotTask) -> update::SlotReply {
        update::SlotReply::Failed(UpdateCode::Flash)
    }

    /// Puts off the watchdog's reset.
    fn feed_watchdog(&mut self);

    /// Resets the device; returns on no board.
    fn reboot(&mut self);
}
