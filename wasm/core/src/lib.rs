//! The core in browsers and Node, without a bench: types are converted and nothing else is done. The other half of the package, the
//! bench, is `wasm`; what waits for answers is TypeScript over this (`wasm/ts`).
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `master.rs`, `requests.rs` | `Master` | [`narx_core::master`] |
//! | `tx_master.rs` | `TxMaster`, `txObjects` | [`narx_core::master::eddycan`] |
//! | `messages.rs` | `decode` | [`narx_core::bus`] |
//! | `can_log.rs` | `readLog` | [`narx_host::can_log`] |
//! | `dictionary.rs` | `parameters`, `scopeSignals`, `measurementSignals`, `logRecords` | [`narx_core::dictionary`] |
//! | `recording.rs` | `replay`, `replayTrace`, `scopeRecording` | [`narx_core::recording`] |
//! | `slcan.rs` | `SlcanLines`, `openSlcan`, `encodeSlcan`, `closeSlcan` | [`narx_sim::can::slcan`] |
//! | `blocks.rs` | `Pi`, `Ramp`, `Hall`, `Commutation`, `ZeroCrossing` | [`narx_core::blocks`] |
//!
//! Names mirror Python's in camel case. Values are SI units, speeds mechanical rpm, times seconds from any beginning.
#![forbid(unsafe_code)]

mod can_log;
mod dictionary;
mod master;
mod messages;
mod recording;
mod requests;
mod slcan;
mod tx_master;

pub use can_log::read_log;
pub use dictionary::{log_records, measurement_signals, parameters, scope_signals};
pub use master::Master;
pub use messages::decode;
pub use recording::{replay, replay_trace, scope_recording};
pub use slcan::{SlcanLines, close_slcan, encode_slcan, open_slcan};
pub use tx_master::{TxMaster, tx_objects};
