//! What talks to drives and TX-Drivers from browsers and Node: types are converted and nothing else is done. The bench is `wasm`, what works on files
//! is `wasm/lab`; what waits for answers is TypeScript over this (`wasm/ts`).
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `master.rs`, `requests.rs`, `update.rs` | `Master`, `speedParameters`, `imageInfo` | [`narx_core::master`] |
//! | `description.rs` | `Master.describe` | [`narx_core::master::DescriptionReader`] |
//! | `tx_master.rs` | `TxMaster`, `txObjects` | [`narx_core::master::eddycan`] |
//! | `messages.rs` | `decode` | [`narx_core::bus`] |
//! | `dictionary.rs` | `parameters`, `scopeSignals`, `measurementSignals`, `logRecords` | [`narx_core::dictionary`] |
//! | `slcan.rs` | `SlcanLines`, `openSlcan`, `encodeSlcan`, `closeSlcan` | [`narx_sim::can::slcan`] |
//!
//! Names mirror Python's in camel case. Values are SI units, speeds mechanical rpm, times seconds from any beginning.
#![forbid(unsafe_code)]

mod description;
mod dictionary;
mod master;
mod messages;
mod requests;
mod slcan;
mod tx_master;
mod update;

pub use dictionary::{log_records, measurement_signals, parameters, scope_signals};
pub use master::{Master, speed_parameters};
pub use messages::decode;
pub use slcan::{SlcanLines, close_slcan, encode_slcan, open_slcan};
pub use tx_master::{TxMaster, tx_objects};
pub use update::image_info;
