//! Samples for other people's tools: logs with the frames that they hold, decoded frames, the database, and
//! the description as a master downloads it.

use crate::{dbc, decoded};
use narx_core::bus::narmotion::{Addresses, MESSAGES, ToDrive, Words, XmlCommand};
use narx_core::bus::{Frame, Id, candump};
use narx_core::dictionary::Parameters;
use narx_core::motor::Board;
use narx_core::node::{Identity, Node};
use narx_sim::can::Bus;
use narx_sim::random::Random;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Writes every sample into a folder.
///
/// # Errors
/// Fails if the folder cannot be written.
pub fn write(directory: &Path) -> std::io::Result<()> {
    fs::create_dir_all(directory)?;
    write_logs(directory)?;
    fs::write(directory.join("narx.dbc"), dbc::render())?;
    fs::write(directory.join("decoded.csv"), decoded_frames())?;
    fs::write(directory.join("description.xml"), description())
}

/// Writes a candump log of frames as they came over the simulated bus, and the same frames as a table.
fn write_logs(directory: &Path) -> std::io::Result<()> {
    let mut bus = Bus::<2, 64>::new(500_000);
    let (Some(sender), Some(receiver)) = (bus.attach(), bus.attach()) else {
        return Err(std::io::Error::other("no place on the bus"));
    };
    for frame in sample_frames() {
        bus.send(sender, frame, 2_500_000_000).map_err(std::io::Error::other)?;
    }
    bus.advance(3_000_000_000);
    let mut log = String::new();
    let mut table = String::from("micros,id,extended,remote,length,data\n");
    while let Some(received) = bus.receive(receiver) {
        let frame = received.frame;
        let data: String = frame.payload().iter().map(|byte| format!("{byte:02x}")).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(log, "{}", candump::line(received.time_ns, "can0", &frame));
        let _ = writeln!(
            table,
            "{},{},{},{},{},{data}",
            received.time_ns / 1_000,
            frame.id().raw(),
            u8::from(frame.id().is_extended()),
            u8::from(frame.is_remote()),
            frame.dlc(),
        );
    }
    fs::write(directory.join("frames.log"), log)?;
    fs::write(directory.join("frames.csv"), table)
}

/// Returns the drive's request word, then data and remote frames of every length with both kinds of
/// identifier. Some have small 29-bit identifiers, which only the number of digits distinguishes from 11-bit
/// ones.
fn sample_frames() -> Vec<Frame> {
    let bytes = [0x00, 0x01, 0x7f, 0x80, 0xff, 0x10, 0x0a, 0xa0];
    let mut frames = vec![(Id::extended(0x0AAD_5202), [0, 0, 0, 1, 0, 0, 0, 0].as_slice(), None)];
    for length in 0..=8u8 {
        let data = &bytes[..usize::from(length)];
        for id in [
            Id::standard(0x7f - u16::from(length)),
            Id::extended(u32::from(length)),
            Id::extended(0x1fff_ffff),
        ] {
            frames.push((id, data, None));
            frames.push((id, data, Some(length)));
        }
    }
    frames
        .into_iter()
        .filter_map(|(id, data, remote)| match remote {
            None => Frame::data(id?, data),
            Some(length) => Frame::remote(id?, length),
        })
        .collect()
}

/// Returns random frames of every message, with a line for each signal of the database: the value that core's
/// decoders read.
fn decoded_frames() -> String {
    let mut random = Random::new(1);
    let mut table = String::from("id,data,signal,value\n");
    for message in &MESSAGES {
        let count = if message.fields().count() == 0 { 1 } else { 300 };
        for _ in 0..count {
            let frame = decoded::random_frame(message, &mut || random.bits());
            // Some random values are not an acknowledgement.
            let Ok(values) = decoded::values(message, &frame) else { continue };
            let data: String = frame.payload().iter().map(|byte| format!("{byte:02x}")).collect();
            let id = frame.id().raw();
            let _ = writeln!(table, "{id},{data},,");
            for (signal, value) in dbc::physical(message, &values) {
                let _ = writeln!(table, "{id},{data},{signal},{value}");
            }
        }
    }
    table
}

/// Downloads the description like a master: words in their place, cut at the length in the answer.
fn description() -> Vec<u8> {
    let mut node = Node::with_parameters(Identity::default(), Board::BENCH, Parameters::new());
    let mut ask = |command| {
        node.handle_frame(&ToDrive::DownloadXml(command).encode(Addresses::FACTORY));
        for now in 0..1000 {
            node.poll(now);
        }
        let frames: Vec<Frame> =
            std::iter::from_fn(|| node.poll_frame().or_else(|| node.poll_bulk_frame())).collect();
        let words = frames.iter().filter_map(|frame| Words::of(frame).ok());
        words
            .filter(|(id, _)| (130..=131).contains(&id.opcode.raw()))
            .map(|(_, Words(words))| words)
            .collect()
    };
    let answer: Vec<[u16; 4]> = ask(XmlCommand::Length);
    let length = answer.first().map_or(0, |words| usize::from(words[0]) * 2);
    let data = ask(XmlCommand::Start);
    let mut text: Vec<u8> =
        data.iter().flat_map(|[_, a, b, c]| [*a, *b, *c]).flat_map(u16::to_be_bytes).collect();
    text.truncate(length);
    text
}
