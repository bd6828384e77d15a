//! Programs for a terminal: the demonstration, the virtual drive, and the signing of images.

#![forbid(unsafe_code)]

pub mod demo;
pub mod drive;
mod motor;
pub mod plot;
pub mod setup;
pub mod sign;
