//! Test of the outputs of one tick as text.

use narx_core::motor::machine::event::{HallCalibration, HallWiring, Status};
use narx_core::motor::{Commutation, PwmCommand, Step};
use narx_core::recording::Outputs;
use std::fmt::{self, Write};

/// Sink that accepts a number of bytes; nothing may be written after the first refused text.
struct Short {
    text: String,
    room: usize,
    full: bool,
}

impl Write for Short {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        assert!(!self.full, "{text:?} behind the end");
        self.full = self.text.len() + text.len() > self.room;
        if self.full {
            return Err(fmt::Error);
        }
        self.text += text;
        Ok(())
    }
}

#[test]
fn a_line_without_room_is_an_error_and_not_a_line_with_gaps() {
    let mut command = PwmCommand::default();
    command.commutations.push(Commutation { instant: 7, step: Step::CA });
    let wiring = HallWiring { order: 1, polarity: 2, offset: -3 };
    let status = Status { hall_calibration: HallCalibration::Done(wiring), ..Status::default() };
    let outputs = Outputs { tick: 17, command, status: Some(status) };
    let whole = outputs.to_string();
    assert!(whole.starts_with("tick 17: duty 0, ") && whole.ends_with("status.crossings 0"), "{whole}");
    for room in 0..=whole.len() {
        let mut short = Short { text: String::new(), room, full: false };
        assert_eq!(write!(short, "{outputs}").is_ok(), room == whole.len(), "{room} bytes");
        assert!(whole.starts_with(&short.text), "{room} bytes: {}", short.text);
    }
}
