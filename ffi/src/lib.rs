//! The narx control core for C. Every item here is written for readers of `include/narx.h`, which is made
//! from this crate. Its files have the names that they have in `narx-core`; they only convert types.
//!
//! ```text
//!   status      results of the calls
//!   fixed       Q formats                         narx_q16_*
//!   board       constants of the board            narx_board_*
//!   samples     inputs of the tick                narx_samples_t
//!   pwm         outputs of the tick               narx_pwm_command_t
//!   frame       CAN frames                        narx_frame_t
//!   device      the drive in the caller's memory  narx_drive_*
//!   inputs      its slow inputs and outputs       narx_drive_*
//!   scope       the memory of its virtual scope   narx_scope_*
//!   storage     its flash                         narx_storage_*
//!   motor       its control tick alone            narx_motor_*, narx_coefficients_build
//!   message     NarMotion-X messages              narx_message_*
//!   master      the master of a drive             narx_master_*
//!   identification, commissioning                 narx_identification_*, narx_commission, narx_speed_loop
//!   blocks      the drive's blocks, one by one    narx_pi_*, narx_ramp_*, narx_hall_*, narx_zero_crossing_*,
//!                                                 narx_commutation_*, narx_fault_*, narx_state_*
//!   eddycan     the TX-Driver and its master      narx_tx_*
//!   recording   replay                            narx_replay*
//! ```
//!
//! On a host the library uses `std`, but only its panic handler; on bare metal it has its own.
#![cfg_attr(target_os = "none", no_std)]
#![allow(non_camel_case_types, reason = "types have the names that C knows them by")]
#![allow(clippy::missing_safety_doc, reason = "one rule for all pointers stands at the head of narx.h")]

mod blocks;
mod board;
mod bus_state;
#[cfg(feature = "engineering")]
mod commissioning;
mod device;
mod eddycan;
mod fixed;
mod frame;
mod handle;
#[cfg(feature = "engineering")]
mod identification;
mod inputs;
mod master;
mod message;
mod motor;
mod pointer;
mod pwm;
mod recording;
mod samples;
mod scope;
mod status;
mod storage;
mod text;

pub use blocks::*;
pub use board::{narx_board_default, narx_board_t, narx_channel_t};
pub use bus_state::narx_bus_state_t;
#[cfg(feature = "engineering")]
pub use commissioning::*;
pub use device::{
    NARX_DRIVE_SIZE, NARX_DRIVE_WORDS, narx_drive_align, narx_drive_get_parameter, narx_drive_handle_frame,
    narx_drive_init, narx_drive_init_stored, narx_drive_poll_bulk_frame, narx_drive_poll_frame,
    narx_drive_run, narx_drive_set_parameter, narx_drive_size, narx_drive_step, narx_drive_t,
    narx_identity_t, narx_stored_t,
};
pub use eddycan::*;
pub use fixed::*;
pub use frame::narx_frame_t;
#[cfg(feature = "engineering")]
pub use identification::*;
pub use inputs::{
    narx_drive_handle_bus_state, narx_drive_handle_inputs, narx_drive_outputs, narx_drive_take_reboot,
    narx_outputs_t, narx_slow_inputs_t,
};
pub use master::*;
pub use message::{NARX_FIELDS_MAX, narx_fields_t, narx_message_decode, narx_message_encode, narx_message_t};
pub use motor::*;
pub use pwm::{NARX_COMMUTATIONS_MAX, narx_commutation_t, narx_pwm_command_t};
pub use recording::{
    NARX_OUTPUTS_TEXT_SIZE, narx_outcome_t, narx_replay, narx_replay_transcript, narx_replay_until,
};
pub use samples::{
    NARX_EDGES_MAX, NARX_LINE_DRIVER_FAULT, NARX_LINE_DSI1, NARX_LINE_DSI2, NARX_LINE_EMERGENCY, narx_edge_t,
    narx_samples_t,
};
pub use scope::{NARX_SCOPE_WORDS, narx_drive_attach_scope, narx_scope_size, narx_scope_t};
pub use status::{narx_status_t, narx_status_text, narx_version};
pub use storage::*;

/// Loops forever, so that the caller's watchdog resets the processor. The core does not panic; this is the
/// last resort.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
