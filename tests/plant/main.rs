//! Tests of the plant against closed forms, an independent integrator, ngspice and data sheets.

mod closed_forms;
mod data_sheets;
mod driving;
mod gated;
mod ledger;
mod reference;
mod sensors;
mod spice;
mod steady;
