//! Evidence for the control core, through its public surfaces.

mod machine_search;
mod transition_table;
