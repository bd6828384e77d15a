//! Experiments on the bench, which tests and reports share: conformance vectors and their replay on every
//! target, worlds in which everything goes wrong at once, the promises and their cost, control quality on
//! random motors, and the certificate of the sensorless start.

#![forbid(unsafe_code)]

pub mod certificate;
pub mod conformance;
pub mod floor;
pub mod identify;
pub mod promises;
pub mod pwm_rate;
pub mod quality;
pub mod running;
pub mod vectors;
pub mod worlds;
