//! The narx control core: a NarMotion-X drive for three-phase BLDC motors in fixed point, without heap, float
//! in the control path, clock or panic. The same bits on every target.
//!
//! ```text
//!                          units  quantities over fixed point
//!                     dictionary  one table of parameters, and their values
//!                            |
//!             Parameters -> build() -> Coefficients
//!                                          |
//!   Samples ------------------------->  motor::Drive  -----> PwmCommand        the control tick
//!                                        ^      |
//!                                  Event |      | Status
//!                                        |      v
//!   CAN frames <---- bus ---->         node::Node             the background
//!
//!   scope       looks at the Drive after each of its ticks; the node asks it for the record
//!   storage     parameters and log on a flash, for the node
//!   description the tables as an XML document, which the node serves
//!   queue       between two halves of which either may interrupt the other, without a way to panic
//!   device      Drive, scope and Node, joined by such queues: what a shell links
//!   master      the other end of the bus, for whatever commands a drive
//!   eddycan     the TX-Driver, another device: eddyCAN on 11-bit identifiers
//!   commissioning    a parameter set from the figures of a motor
//!   identification   those figures, measured by its drive, through a master
//!   blocks      the drive's stations one by one, for whoever wants one of them alone
//!   initialiser coefficients as constants of a C program
//!   recording   initial state + samples + events of a Drive, and a digest of what it answered
//! ```
//!
//! Data flows down this list, and so do the imports: `units`, `dictionary`, `motor`, `scope`, `bus`,
//! `storage`, `description`, `node`, `queue`, `device`, `master`, `recording`; `eddycan` stands beside them
//! on `bus` alone, `blocks`, `initialiser` and `commissioning` on `motor`, `identification` on `master` and
//! `commissioning`.
//!
//! Two state machines with one owner each: [`motor::Drive`] belongs to the control tick, [`node::Node`] to
//! the background. Both take everything as arguments, time included, and return what they answer.
//!
//! Features that are on by default and that a small board may leave out: `names` and `description` (texts),
//! `log`, `scope` and its `recorder`, `hall-calibration` and `accelerometer`. A request for a part that is
//! left out is refused. Two more are off by default: `update` (programming over CAN) and `code-flash`
//! (parameters in the flash that the code runs from). Two more are not for a drive: `engineering` (parameters
//! in their units, as floating-point numbers; `initialiser`, `commissioning`, `identification`) and `blind`
//! (for checking the tests).
#![no_std]
#![forbid(unsafe_code)]

#[cfg(feature = "blind")]
extern crate std;

mod blind;
pub mod blocks;
pub mod bus;
#[cfg(feature = "engineering")]
pub mod commissioning;
pub mod description;
pub mod device;
pub mod dictionary;
pub mod eddycan;
#[cfg(feature = "engineering")]
pub mod identification;
#[cfg(feature = "engineering")]
pub mod initialiser;
pub mod master;
pub mod motor;
pub mod node;
pub mod queue;
pub mod recording;
pub mod scope;
#[cfg(feature = "engineering")]
pub mod shown;
pub mod storage;
pub mod units;
