//! Parts of the bench that need an operating system: threads for many runs at once and for long logs, sockets
//! and terminals for other people's tools.

#![forbid(unsafe_code)]

pub mod can_log;
#[cfg(feature = "simulator")]
pub mod csv;
#[cfg(feature = "fmu")]
pub mod fmu;
pub mod parallel;
#[cfg(feature = "simulator")]
pub mod serve;
