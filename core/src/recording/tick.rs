//! One tick as the difference to the one before: both directions, side by side.

use super::bytes::{Cursor, Payload, push_varint, unzigzag, zigzag};
use super::{ReadError, Tick};
use crate::motor::machine::event::Event;
use crate::motor::{CurrentMode, Edge, EdgeSource, Lines, SampleMode, Samples};

/// Bits of the change mask above the five converter codes.
const HALL: u64 = 1 << 5;
const EDGES: u64 = 1 << 6;
const EVENT: u64 = 1 << 7;
const TICK: u64 = 1 << 8;
const SAMPLE_MODE: u64 = 1 << 9;
const CURRENT_MODE: u64 = 1 << 10;
const SKEW: u64 = 1 << 11;
const EDGES_LOST: u64 = 1 << 12;
const LINES: u64 = 1 << 13;
const ALL: u64 = (1 << 14) - 1;

/// Appends the record of one tick; `None`, with `out` in no defined state beyond its old end, when there is
/// no room.
pub(super) fn encode(
    out: &mut Payload,
    event: Option<&Event>,
    samples: &Samples,
    before: &Samples,
) -> Option<()> {
    let tick_jump = samples.tick.wrapping_sub(before.tick.wrapping_add(1)) as i64;
    let mut mask = 0;
    for (bit, (now, then)) in codes(samples).into_iter().zip(codes(before)).enumerate() {
        mask |= u64::from(now != then) << bit;
    }
    for (bit, changed) in [
        (HALL, samples.hall != before.hall),
        (EDGES, !samples.edges.is_empty()),
        (EVENT, event.is_some()),
        (TICK, tick_jump != 0),
        (SAMPLE_MODE, samples.sample_mode != before.sample_mode),
        (CURRENT_MODE, samples.current_mode != before.current_mode),
        (SKEW, samples.skew != before.skew),
        (EDGES_LOST, samples.edges_lost != 0),
        (LINES, samples.lines != before.lines),
    ] {
        mask |= if changed { bit } else { 0 };
    }

    push_varint(out, mask)?;
    for (now, then) in codes(samples).into_iter().zip(codes(before)) {
        if now != then {
            push_varint(out, zigzag(i64::from(now.wrapping_sub(then) as i16)))?;
        }
    }
    if mask & HALL != 0 {
        out.push(samples.hall).ok()?;
    }
    if mask & EDGES != 0 {
        encode_edges(out, &samples.edges)?;
    }
    if let Some(event) = event {
        encode_event(out, event)?;
    }
    if mask & TICK != 0 {
        push_varint(out, zigzag(tick_jump))?;
    }
    if mask & SKEW != 0 {
        out.extend_from_slice(&samples.skew.to_le_bytes()).ok()?;
    }
    if mask & EDGES_LOST != 0 {
        out.push(samples.edges_lost).ok()?;
    }
    if mask & LINES != 0 {
        out.push(samples.lines.bits()).ok()?;
    }
    Some(())
}

/// Reads the record of one tick.
pub(super) fn decode(from: &mut Cursor<'_>, before: &Samples) -> Result<Tick, ReadError> {
    let at = from.at();
    let mask = from.varint("a change mask")?;
    if mask & !ALL != 0 {
        return Err(ReadError::Malformed { at, expected: "a change mask of 14 bits" });
    }
    let mut samples =
        Samples { edges: heapless::Vec::new(), edges_lost: 0, hall: before.hall, ..before.clone() };
    for (bit, code) in codes_mut(&mut samples).into_iter().enumerate() {
        if mask & (1 << bit) != 0 {
            *code = code.wrapping_add(unzigzag(from.varint("a converter code")?) as u16);
        }
    }
    if mask & HALL != 0 {
        samples.hall = from.u8("a hall code")?;
    }
    if mask & EDGES != 0 {
        decode_edges(from, &mut samples)?;
    }
    let event = if mask & EVENT != 0 { Some(decode_event(from)?) } else { None };
    let jump = if mask & TICK != 0 { unzigzag(from.varint("a tick number")?) } else { 0 };
    samples.tick = before.tick.wrapping_add(1).wrapping_add(jump as u64);
    if mask & SAMPLE_MODE != 0 {
        samples.sample_mode = match before.sample_mode {
            SampleMode::OffTime => SampleMode::OnTime,
            SampleMode::OnTime => SampleMode::OffTime,
        };
    }
    if mask & CURRENT_MODE != 0 {
        samples.current_mode = match before.current_mode {
            CurrentMode::Average => CurrentMode::OnTime,
            CurrentMode::OnTime => CurrentMode::Average,
        };
    }
    if mask & SKEW != 0 {
        samples.skew = from.u16("the sampling skew")?;
    }
    if mask & EDGES_LOST != 0 {
        samples.edges_lost = from.u8("the count of lost edges")?;
    }
    if mask & LINES != 0 {
        samples.lines = Lines::from_bits_retain(from.u8("the digital lines")?);
    }
    Ok(Tick { event, samples })
}

/// The converter codes in the order of the mask's bits.
const fn codes(samples: &Samples) -> [u16; 5] {
    let [a, b, c] = samples.phase_voltage;
    [a, b, c, samples.bus_voltage, samples.bus_current]
}

fn codes_mut(samples: &mut Samples) -> [&mut u16; 5] {
    let [a, b, c] = &mut samples.phase_voltage;
    [a, b, c, &mut samples.bus_voltage, &mut samples.bus_current]
}

fn encode_edges(out: &mut Payload, edges: &[Edge]) -> Option<()> {
    out.push(edges.len() as u8).ok()?;
    for edge in edges {
        out.extend_from_slice(&edge.instant.to_le_bytes()).ok()?;
        let source = match edge.source {
            EdgeSource::Hall => 0,
            EdgeSource::Comparator => 1,
        };
        push_varint(out, u64::from(edge.code) << 1 | source)?;
    }
    Some(())
}

fn decode_edges(from: &mut Cursor<'_>, samples: &mut Samples) -> Result<(), ReadError> {
    let start = from.at();
    for _ in 0..from.u8("a count of edges")? {
        let instant = from.u16("an edge's instant")?;
        let at = from.at();
        let packed = from.varint("an edge's code and source")?;
        let code = u8::try_from(packed >> 1)
            .map_err(|_| ReadError::Malformed { at, expected: "an edge's code and source" })?;
        let source = if packed & 1 == 0 { EdgeSource::Hall } else { EdgeSource::Comparator };
        samples
            .edges
            .push(Edge { instant, source, code })
            .map_err(|_| ReadError::Malformed { at: start, expected: "no more than 4 edges" })?;
    }
    Ok(())
}

fn encode_event(out: &mut Payload, event: &Event) -> Option<()> {
    let length_at = out.len();
    let start = length_at + 2;
    out.resize(out.capacity(), 0).ok()?;
    let length = postcard::to_slice(event, out.get_mut(start..)?).ok()?.len();
    out.get_mut(length_at..start)?.copy_from_slice(&(length as u16).to_le_bytes());
    out.truncate(start + length);
    Some(())
}

fn decode_event(from: &mut Cursor<'_>) -> Result<Event, ReadError> {
    let length = from.u16("an event's length")?;
    let at = from.at();
    let malformed = ReadError::Malformed { at, expected: "an event of this layout" };
    match postcard::take_from_bytes(from.take(usize::from(length), "an event")?) {
        Ok((event, [])) => Ok(event),
        _ => Err(malformed),
    }
}
