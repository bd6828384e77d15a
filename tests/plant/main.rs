//! The plant against closed forms, an independent integrator, ngspice and data sheets.

mod data_sheets;
mod driving;
mod ledger;
mod steady;
