//! Reasons to end a drive: the fault table and its logic, an open phase, and the rails of a start without
//! sensors.

pub mod fault;
pub mod open_phase;
pub mod protection;
pub mod rails;
