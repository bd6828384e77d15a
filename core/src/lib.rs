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
//! # A drive, its ticks and its frames
//!
//! The control tick alone: coefficients are built from parameters and a board, then each period's samples
//! give a command to the bridge.
//!
//! ```
//! use narx_core::dictionary::{Parameters, number};
//! use narx_core::motor::{Board, Coefficients, Drive, Samples, Step};
//!
//! let mut parameters = Parameters::new();
//! parameters.set(number::HALL_ENABLE, 1)?;
//! let coefficients = Coefficients::build(&parameters, &Board::BENCH).expect("they fit together");
//! let mut drive = Drive::new(coefficients);
//!
//! // 24 V on the bus, no current, the rotor in sector 0.
//! let samples = Samples { bus_voltage: 1229, bus_current: 2048, hall: 0b001, ..Samples::default() };
//! let command = drive.step(&samples);
//! assert_eq!(command.step, Step::Coast); // nobody has asked for more
//! # Ok::<(), narx_core::dictionary::ParameterError>(())
//! ```
//!
//! A whole device: the tick in an interrupt, the node in the background. A frame sets a parameter, and one
//! answers it.
//!
//! ```
//! use narx_core::bus::narmotion::{FromDrive, ParameterStatus, ToDrive};
//! use narx_core::device::Queues;
//! use narx_core::dictionary::{Parameters, number};
//! use narx_core::motor::{Board, Samples};
//! use narx_core::node::Identity;
//!
//! let mut queues = Queues::new(); // in a firmware a static
//! let (mut tick, mut background) =
//!     queues.power_up(Identity::default(), Board::BENCH, Parameters::new());
//! let request = ToDrive::SetParameter { number: number::SPEED_RATE, value: 1_000 };
//! let request = request.encode(background.node().addresses());
//!
//! let mut answer = None;
//! for now in 0..10_000 {
//!     // The control interrupt, once a PWM period.
//!     let _command = tick.step(&Samples { tick: now, ..Samples::default() }); // for the bridge
//!     // The background, once a period or less often.
//!     if now == 8_000 {
//!         background.node().handle_frame(&request);
//!     }
//!     background.run(now);
//!     while let Some(frame) = background.node().poll_frame() {
//!         if let Ok((_, FromDrive::Parameter { number, value, status })) = FromDrive::decode(&frame) {
//!             answer = Some((number, value, status));
//!         }
//!     }
//! }
//! assert_eq!(answer, Some((number::SPEED_RATE, 1_000, ParameterStatus::Done)));
//! ```
//!
//! # Features
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
