//! The plant against closed forms, an independent integrator, ngspice and data sheets.

mod driving;
mod steady;
