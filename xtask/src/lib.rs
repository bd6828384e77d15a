//! What the developer commands are made of.

pub mod candump;
pub mod csv;
pub mod interop;
pub mod plot;
pub mod steps;
