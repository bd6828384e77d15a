//! narx's frames and embassy's, for two tasks around the controller.

use embassy_stm32::can::config::TxBufferMode;
use embassy_stm32::can::enums::BusErrorMode;
use embassy_stm32::can::{CanConfigurator, CanRx, CanTx, Frame as CanFrame, Properties};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use narx_core::bus::{BusState, ErrorState, Frame};

/// Frames between the controller's tasks and the node's.
pub type Frames<const N: usize> = Channel<CriticalSectionRawMutex, Frame, N>;

/// From the bus. What finds no room is lost, as in a controller whose FIFO is full.
pub static ARRIVING: Frames<32> = Channel::new();
/// To the bus.
pub static LEAVING: Frames<4> = Channel::new();

/// Sets the controller up: 500 kbit/s, frames in the order in which they were given. By embassy's default
/// those of one identifier may overtake each other.
pub fn configure(bus: &mut CanConfigurator<'_>) {
    let in_order = bus.config().set_tx_buffer_mode(TxBufferMode::Fifo);
    bus.set_config(in_order.set_automatic_bus_off_recovery(true));
    bus.set_bitrate(500_000);
}

/// Copies a frame from one type to another.
fn convert<A: embedded_can::Frame, B: embedded_can::Frame>(frame: &A) -> Option<B> {
    if frame.is_remote_frame() {
        B::new_remote(frame.id(), frame.dlc())
    } else {
        B::new(frame.id(), frame.data())
    }
}

/// Receives for ever.
pub async fn receive(mut bus: CanRx<'static>) -> ! {
    loop {
        // An error on the bus is in the controller's state, which the node reads.
        if let Ok(envelope) = bus.read().await
            && let Some(frame) = convert(&envelope.frame)
        {
            let _ = ARRIVING.try_send(frame);
        }
    }
}

/// Sends for ever.
pub async fn send(mut bus: CanTx<'static>) -> ! {
    loop {
        if let Some(frame) = convert::<_, CanFrame>(&LEAVING.receive().await) {
            bus.write(&frame).await;
        }
    }
}

/// Returns the controller's fault confinement.
pub fn state(bus: &Properties) -> BusState {
    BusState {
        error: match bus.bus_error_mode() {
            BusErrorMode::ErrorActive => ErrorState::Active,
            BusErrorMode::ErrorPassive => ErrorState::Passive,
            BusErrorMode::BusOff => ErrorState::BusOff,
        },
        transmit_errors: bus.tx_error_count().into(),
        receive_errors: bus.rx_error_count().into(),
    }
}
