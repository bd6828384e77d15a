//! Self-tests of a microcontroller, without the microcontroller: what a board does with its memories and
//! clocks is decided here.
//!
//! ```text
//!   at boot    march  RAM             clock  one clock against another      a failed one is a bit of SelfTests,
//!   in run     walk   the program     clock  control ticks against a clock  by the shell to the node: fault bit 27
//! ```
//!
//! The canary at the end of the stack is a comparison that needs no words here.

pub mod clock;
pub mod march;
pub mod walk;
