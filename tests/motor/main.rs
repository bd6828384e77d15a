//! Evidence for the control core, through its public surfaces.

mod arithmetic;
mod commutation;
mod limits;
mod machine_search;
mod protection;
mod support;
mod transition_table;
