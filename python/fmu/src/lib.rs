//! The library inside a narx FMU: the C functions of FMI 2.0 and 3.0, co-simulation, over [`narx_host::fmu`].
//!
//! Every function has the name and the arguments of the standard. Pointers are the importer's, and are valid
//! as the standard promises; a null where it forbids one is answered with an error.
#![allow(non_snake_case, reason = "the names of the standard")]

mod fmi2;
mod fmi3;
mod instance;
