//! Test that the tables of TX-Drivers in PROTOCOL.md are made from the code and up to date.

use narx_core::bus::eddycan::{AbortCode, Bitrate, ErrorCode, IDENTIFIERS, Layout};
use narx_core::eddycan::OBJECTS;
use narx_tests::{Block, check_blocks};
use std::fmt::Write;

const BLOCKS: [Block; 5] = [
    ("eddycan-identifiers", identifiers),
    ("eddycan-objects", objects),
    ("eddycan-bitrates", bitrates),
    ("eddycan-aborts", aborts),
    ("eddycan-errors", errors),
];

fn identifiers() -> String {
    let mut out = String::from("| message | identifier | direction | purpose |\n|---|---|---|---|\n");
    for row in &IDENTIFIERS {
        let node = if row.node { " + node-id" } else { "" };
        let direction = if row.from_node { "N to M" } else { "M to N" };
        writeln!(out, "| {} | {:03X}h{node} | {direction} | {} |", row.name, row.base, row.purpose).unwrap();
    }
    out
}

fn objects() -> String {
    let mut out = String::from(
        "| index | sub | name | type | access | unit | range | factory | acts | what it does |\n\
         |---|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in &OBJECTS {
        let subindex = row.subindex.map_or("-".into(), |subindex| subindex.to_string());
        let acts = if row.restart { "after a restart" } else { "at once" };
        writeln!(
            out,
            "| {:04X}h | {subindex} | {} | {} | {} | {} | {} to {} | {} | {acts} | {} |",
            row.index,
            row.name,
            row.kind.label(),
            row.access.label(),
            row.unit,
            row.min,
            row.max,
            row.default,
            row.description
        )
        .unwrap();
    }
    out
}

/// Table of the longest frames of the three lengths that PDOs have.
fn bitrates() -> String {
    let mut out = String::from(
        "| index | kbit/s | cable, m | longest PDO of 4 bytes, us | 6 bytes | 8 bytes |\n|---|---|---|---|---|---|\n",
    );
    for bitrate in Bitrate::ALL {
        let [four, eight, six, _] = Layout::ALL.map(|layout| bitrate.longest_frame_us(layout.length()));
        let (index, kilobits, metres) =
            (bitrate as u8, bitrate.bits_per_second() / 1000, bitrate.cable_metres());
        writeln!(out, "| {index} | {kilobits} | {metres} | {four} | {six} | {eight} |").unwrap();
    }
    out
}

fn aborts() -> String {
    let mut out = String::from("| code | meaning |\n|---|---|\n");
    for code in AbortCode::ALL {
        writeln!(out, "| {:08X}h | {} |", code as u32, code.meaning()).unwrap();
    }
    out
}

fn errors() -> String {
    let mut out = String::from("| code | meaning |\n|---|---|\n");
    for code in ErrorCode::ALL {
        writeln!(out, "| {:04X}h | {} |", code as u16, code.meaning()).unwrap();
    }
    out
}

#[test]
fn generated_tables_are_up_to_date() {
    check_blocks(&BLOCKS);
}
