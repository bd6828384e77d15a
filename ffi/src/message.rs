//! NarMotion-X messages, for a program that needs only the protocol.

use crate::frame::narx_frame_t;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::bus::Frame;
use narx_core::bus::narmotion::{
    Addresses, DecodeError, FromDrive, MESSAGES, Message, MessageKind, ToDrive, Words,
};

/// Largest number of fields of a message.
pub const NARX_FIELDS_MAX: usize = 7;

/// The fields of a message. In C it is a union of these words with a structure for each message, made from
/// the table: `message.fields.status_word.motor_mode`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct narx_fields_t {
    /// Raw numbers in the order of the fields in the table; a signed one as its bits.
    pub raw: [u32; NARX_FIELDS_MAX],
}

/// A NarMotion-X message (PROTOCOL.md, section 2).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_message_t {
    /// Kind: a narx_message_kind_t.
    pub kind: u16,
    /// CAN address of the drive; 170 as shipped.
    pub drive: u8,
    /// CAN address of the master; 85 as shipped.
    pub master: u8,
    /// Fields: raw numbers, with unit and scale beside each. The fields of other messages are ignored.
    pub fields: narx_fields_t,
}

/// Decodes a frame. Returns NARX_ERROR_NOT_A_MESSAGE if it is none of narx_message_kind_t, or not well
/// formed; NARX_ERROR_FIELD if a field has an undefined value. The priority in the identifier is ignored. Any
/// context; no state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_message_decode(
    frame: *const narx_frame_t,
    message: *mut narx_message_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(message)?;
        pointer::write(message, decode(&pointer::read(frame)?.try_into()?)?)
    };
    pointer::status(run())
}

/// Encodes a message as a frame. Returns NARX_ERROR_NOT_A_MESSAGE if `kind` is no narx_message_kind_t;
/// NARX_ERROR_FIELD if a field has an undefined value or one that does not fit in its bits. Any context; no
/// state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_message_encode(
    message: *const narx_message_t,
    frame: *mut narx_frame_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        pointer::check(frame)?;
        pointer::write(frame, encode(pointer::read(message)?)?.into())
    };
    pointer::status(run())
}

pub(crate) fn decode(frame: &Frame) -> Result<narx_message_t, narx_status_t> {
    let (id, words) = Words::of(frame)?;
    let row = Message::of(id).ok_or(NARX_ERROR_NOT_A_MESSAGE)?;
    check(row, frame)?;
    let mut fields = narx_fields_t::default();
    for (raw, field) in fields.raw.iter_mut().zip(row.fields()) {
        *raw = field.raw(words) as u32;
    }
    let (drive, master) = match id.kind {
        MessageKind::SlaveTx => (id.source, id.destination),
        MessageKind::DataSet | MessageKind::DataRequest => (id.destination, id.source),
    };
    Ok(narx_message_t { kind: kind(row), drive, master, fields })
}

fn encode(message: &narx_message_t) -> Result<Frame, narx_status_t> {
    let row = MESSAGES.iter().find(|row| kind(row) == message.kind).ok_or(NARX_ERROR_NOT_A_MESSAGE)?;
    let mut words = Words::default();
    for (raw, field) in message.fields.raw.iter().zip(row.fields()) {
        let raw = if field.signed { i64::from(*raw as i32) } else { i64::from(*raw) };
        field.put(raw, &mut words)?;
    }
    let id = row.id(Addresses { drive: message.drive, master: message.master });
    let frame = words.frame(id);
    check(row, &frame)?;
    Ok(frame)
}

/// Returns an error if a field has an undefined value.
fn check(row: &Message, frame: &Frame) -> Result<(), narx_status_t> {
    match row.kind {
        MessageKind::SlaveTx => FromDrive::decode(frame).map(drop)?,
        MessageKind::DataSet | MessageKind::DataRequest => ToDrive::decode(frame).map(drop)?,
    }
    Ok(())
}

/// Returns the low 11 bits of the message's identifier: type and opcode.
fn kind(row: &Message) -> u16 {
    (row.kind as u16) << 9 | row.opcode.raw()
}

impl From<DecodeError> for narx_status_t {
    fn from(error: DecodeError) -> Self {
        match error {
            DecodeError::Value => NARX_ERROR_FIELD,
            DecodeError::StandardId
            | DecodeError::Remote
            | DecodeError::Length
            | DecodeError::Kind
            | DecodeError::Opcode => NARX_ERROR_NOT_A_MESSAGE,
        }
    }
}
