//! Evidence for the control core, through its public surfaces.

mod acknowledgement;
mod arithmetic;
mod bench;
mod boot;
mod build;
mod closed_loop;
mod commutation;
mod extremes;
mod flying_start;
mod hall;
mod hall_drive;
mod limits;
mod live;
mod machine_search;
mod presets;
mod protection;
mod rotor;
mod safety;
mod scripted;
mod sensorless;
mod sensorless_range;
mod session;
mod steady;
mod support;
mod transition_table;
mod zero_crossing;
