//! What the bench needs of an operating system: threads for many runs at once, sockets and terminals for other people's tools.

#![forbid(unsafe_code)]

pub mod parallel;
pub mod serve;
