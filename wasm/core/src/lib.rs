//! Masters of drives and TX-Drivers, and their messages, for browsers and Node. The crate only converts
//! types. The bench is `wasm`, functions for files are `wasm/lab`; calls that wait for answers are TypeScript
//! over this (`wasm/ts`).
//!
//! | file | JavaScript | Rust |
//! |---|---|---|
//! | `master.rs`, `requests.rs` | `Master`, `speedParameters` | [`narx_core::master`] |
//! | `identification.rs` | `Identification` | [`narx_core::identification`] |
//! | `identification.rs` | `commission` | [`narx_core::commissioning`] |
//! | `update.rs` | `Master`, `imageInfo` | [`narx_core::master`] |
//! | `description.rs` | `Master.describe` | [`narx_core::master::DescriptionReader`] |
//! | `tx_master.rs` | `TxMaster`, `txObjects` | [`narx_core::master::eddycan`] |
//! | `messages.rs` | `decode` | [`narx_core::bus`] |
//! | `dictionary.rs` | `parameters`, `logRecords` | [`narx_core::dictionary`] |
//! | `dictionary.rs` | `scopeSignals`, `measurementSignals` | [`narx_core::dictionary`] |
//! | `slcan.rs` | `SlcanLines`, `openSlcan`, `encodeSlcan`, `closeSlcan` | [`narx_core::bus::slcan`] |
//!
//! Names are those of Python in camel case. Values are SI units, speeds mechanical rpm, times seconds from
//! any beginning.
#![forbid(unsafe_code)]

mod description;
mod dictionary;
mod identification;
mod master;
mod messages;
mod requests;
mod slcan;
mod tx_master;
mod update;

pub use dictionary::{log_records, measurement_signals, parameters, scope_signals};
pub use identification::{Identification, commission};
pub use master::{Master, speed_parameters};
pub use messages::decode;
pub use slcan::{SlcanLines, close_slcan, encode_slcan, open_slcan};
pub use tx_master::{TxMaster, tx_objects};
pub use update::image_info;
