//! Tables and vectors for a port by hand to a processor without a Rust compiler: `ffi/examples/port_tables.h`
//! and `ffi/examples/port_vectors.h`, C99 of its own, for integers of 16 bits and bytes of 16.

use crate::Made;
use narx_core::blocks::{Hall, HallSettings, Pi, PiSettings, Ramp, RampSettings, SettingError};
use narx_core::dictionary::{Dictionary, Kind};
use narx_core::motor::commutate::commutation::sector_of;
use narx_core::motor::gain::Gain;
use narx_core::motor::machine::state::{Conditions, TRANSITIONS};
use narx_core::motor::rotor::hall::{HallWiring, sectors};
use narx_core::motor::{Cause, Direction, Leg, State, Step};
use narx_core::units::ElectricalAngle;
use std::fmt::{Display, Write};
use std::path::Path;

const TABLES: &str = "ffi/examples/port_tables.h";
const VECTORS: &str = "ffi/examples/port_vectors.h";
/// Steps of a vector.
const STEPS: usize = 200;

/// Makes both files.
///
/// # Errors
/// Fails if the settings of a vector do not build.
pub fn make(_: &Path) -> Result<Made, String> {
    let vectors = vectors().map_err(|error| error.to_string())?;
    let files = vec![(TABLES.into(), tables()), (VECTORS.into(), vectors)];
    Ok(Made { summary: format!("5 tables and 4 vectors of {STEPS} steps"), files })
}

/// Renders the tables of the specification and of its decisions.
fn tables() -> String {
    let mut text = String::from(
        "/* Tables of the NarMotion-X drive for a port by hand, made from narx's own. No other header of narx is needed. */

#ifndef NARX_PORT_TABLES_H
#define NARX_PORT_TABLES_H

#include <stdint.h>

#define NARX_PORT_INVALID 255

/* Sector by hall code (bit 0 = A) and order of the lines (parameter 262); invert the lines (parameter 263) before. Sector s
 * spans 30 + 60 s to 90 + 60 s electrical degrees. */
",
    );
    let by_order = (0..6).map(|order| sectors(HallWiring { order, ..HallWiring::default() }));
    array(&mut text, "uint_least8_t", "narx_port_sectors[6][8]", by_order.map(listed));
    text.push_str(
        "
/* Legs A, B, C by torque (0 forward, 1 reverse) and sector: 1 is switched with the duty, -1 has its low side on, 0 is off. */
",
    );
    let legs = |direction| {
        let rows = (0..6).map(move |sector| listed(Step::for_sector(sector, direction).legs().map(level)));
        format!("{{{}}}", rows.collect::<Vec<_>>().join(", "))
    };
    array(
        &mut text,
        "int_least8_t",
        "narx_port_legs[2][6][3]",
        [Direction::Forward, Direction::Reverse].map(legs),
    );
    text.push_str("\n/* States (section 7). */\nenum narx_port_state {\n");
    let states = State::ALL
        .map(|state| format!("    NARX_PORT_STATE_{} = {}", shouted(&format!("{state:?}")), state as u8));
    let _ = writeln!(text, "{}\n}};", states.join(",\n"));
    text.push_str(
        "\n/* Conditions of the transitions, as bits: core/src/motor/machine/state.rs says when each holds. */\n",
    );
    for (name, bit) in Conditions::all().iter_names() {
        let _ = writeln!(text, "#define NARX_PORT_IF_{name} UINT16_C(0x{:04X})", bit.bits());
    }
    text.push_str(
        "
/* Table 7: from this state to that one when all of `all` and none of `none` hold. The first row that holds wins. */
struct narx_port_transition {
    uint_least8_t from;
    uint_least8_t to;
    uint_least16_t all;
    uint_least16_t none;
};
",
    );
    let rows = TRANSITIONS.iter().map(|row| {
        format!(
            "{{{}, {}, 0x{:04X}u, 0x{:04X}u}}",
            row.from as u8,
            row.to as u8,
            row.all.bits(),
            row.none.bits()
        )
    });
    array(
        &mut text,
        "struct narx_port_transition",
        &format!("narx_port_transitions[{}]", TRANSITIONS.len()),
        rows,
    );
    text.push_str(
        "
/* Table 9: extended code, whose high byte is the bit of the fault word, and qualification time, us. */
struct narx_port_fault {
    uint_least16_t code;
    uint_least32_t qualification;
};
",
    );
    let rows = Cause::TABLE.iter().map(|row| {
        format!("{{0x{:04X}u, UINT32_C({})}} /* {} */", row.cause as u16, row.qualification, row.meaning)
    });
    array(&mut text, "struct narx_port_fault", &format!("narx_port_faults[{}]", Cause::TABLE.len()), rows);
    text.push_str(
        "
/* Parameters as they are on the wire: a value in its unit is raw * 10^exponent. An unsigned one of 32 bits is the same bits. */
struct narx_port_parameter {
    uint_least16_t number;
    int_least8_t exponent;
    int_least32_t minimum;
    int_least32_t maximum;
    int_least32_t factory;
};
",
    );
    let rows: Vec<String> = Dictionary::rows()
        .map(|row| {
            let value =
                |value: i64| literal(if row.kind == Kind::U32 { value as u32 as i32 } else { value as i32 });
            format!(
                "{{{}, {}, {}, {}, {}}} /* {}, {} */",
                row.number,
                row.exponent,
                value(row.min()),
                value(row.max()),
                literal(row.factory_raw()),
                row.name(),
                row.unit()
            )
        })
        .collect();
    array(&mut text, "struct narx_port_parameter", &format!("narx_port_parameters[{}]", rows.len()), rows);
    text.push_str("\n#endif\n");
    text
}

/// Renders inputs and outputs of the blocks, a step a row.
fn vectors() -> Result<String, SettingError> {
    let mut text = String::from(
        "/* Vectors for a port by hand: what the blocks of narx answer, bit by bit. Values are Q16 where nothing else is said. */

#ifndef NARX_PORT_VECTORS_H
#define NARX_PORT_VECTORS_H

#include <stdint.h>

",
    );
    let _ = writeln!(text, "enum {{ NARX_PORT_STEPS = {STEPS} }};");
    let settings = PiSettings {
        proportional: Gain::new(16_384, 15).unwrap_or_default(),
        integral: Gain::new(5 << 24, 24).unwrap_or_default(),
        step_rate: 1000,
        minimum: -(6 << 16),
        maximum: 6 << 16,
    };
    let mut pi = Pi::build(&settings)?;
    let pair = |gain: Gain| listed([literal(gain.mantissa()), shown(gain.shift())]);
    let gains = pi.ready().gains;
    let (proportional, integral) = (pair(gains.proportional), pair(gains.integral));
    let _ = write!(
        text,
        "
/* A PI controller: gains are mantissa * 2^-shift, output within minimum and maximum. */
static const int32_t narx_port_pi_gains[2][2] = {{{proportional}, {integral}}};
static const int32_t narx_port_pi_limits[2] = {{{}, {}}};
/* Error, output. */
",
        literal(settings.minimum),
        literal(settings.maximum)
    );
    let errors = (0..STEPS).map(wave);
    let rows = errors.map(|error| listed([literal(error), literal(pi.step(error))]));
    array(&mut text, "int32_t", "narx_port_pi[NARX_PORT_STEPS][2]", rows);

    let mut ramp = Ramp::build(&RampSettings { rate: 100 << 16, step_rate: 1000 })?;
    let _ = write!(
        text,
        "
/* A ramp: rate a step, with 16 fraction bits more. */
static const int64_t narx_port_ramp_rate = INT64_C({});
/* Target, value. */
",
        ramp.ready().rate
    );
    let rows = (0..STEPS).map(|step| {
        let target = if step < 120 { 10 << 16 } else { -(3 << 16) };
        listed([literal(target), literal(ramp.step(target))])
    });
    array(&mut text, "int32_t", "narx_port_ramp[NARX_PORT_STEPS][2]", rows);

    text.push_str("\n/* Electrical angle, 65536 a turn, and its sector. */\n");
    let angles = (0..STEPS as u32).map(|step| (step * 65_536 / STEPS as u32) as u16);
    let rows = angles.map(|angle| listed([angle, sector_of(ElectricalAngle(angle)).into()]));
    array(&mut text, "uint16_t", "narx_port_angles[NARX_PORT_STEPS][2]", rows);

    // Sampled codes of a motor that speeds up, and an invalid one.
    let mut hall = Hall::build(&HallSettings { captured: false, ..HallSettings::default() })?;
    text.push_str(
        "
/* Hall sensors without captured edges, in the factory's wiring, 10000 ticks a second. Code; sector, or NARX_PORT_INVALID; angle,
 * 65536 a turn; electrical speed, rev/s. */
",
    );
    const CODES: [u8; 6] = [1, 3, 2, 6, 4, 5];
    let rows = (0..STEPS).map(|tick| {
        let code = if tick == 150 { 7 } else { CODES[tick * tick / 1500 % 6] };
        let reading = hall.step(code, &[]);
        listed([
            shown(code),
            shown(reading.sector.unwrap_or(255)),
            shown(reading.position.angle >> 16),
            literal(reading.speed.to_bits()),
        ])
    });
    array(&mut text, "int32_t", "narx_port_hall[NARX_PORT_STEPS][4]", rows);
    text.push_str("\n#endif\n");
    Ok(text)
}

/// An error that swings, with a part that drives the controller into each of its limits.
fn wave(step: usize) -> i32 {
    match step {
        0..80 => 10 << 16,
        80..160 => -((7 << 16) + 321),
        _ => ((step as i32 * 37_511) & 0x1_FFFF) - 0x1_0000,
    }
}

fn level(leg: Leg) -> i8 {
    match leg {
        Leg::Switched => 1,
        Leg::Low => -1,
        Leg::Floating => 0,
    }
}

/// A name in capitals: `HallClosedLoop` is `HALL_CLOSED_LOOP`.
fn shouted(name: &str) -> String {
    let mut text = String::new();
    for letter in name.chars() {
        if letter.is_ascii_uppercase() && !text.is_empty() {
            text.push('_');
        }
        text.push(letter.to_ascii_uppercase());
    }
    text
}

/// A constant of 32 bits on a processor whose `int` has 16.
fn literal(value: i32) -> String {
    if value == i32::MIN { "INT32_MIN".into() } else { format!("INT32_C({value})") }
}

fn shown(value: impl Display) -> String {
    value.to_string()
}

fn listed(values: impl IntoIterator<Item = impl Display>) -> String {
    let values: Vec<String> = values.into_iter().map(shown).collect();
    format!("{{{}}}", values.join(", "))
}

/// Appends the definition of an array. A comment of a row stands behind its comma.
fn array(text: &mut String, kind: &str, name: &str, rows: impl IntoIterator<Item = String>) {
    let _ = writeln!(text, "static const {kind} {name} = {{");
    for row in rows {
        let (value, comment) = row
            .split_once(" /*")
            .map_or((row.as_str(), String::new()), |(value, comment)| (value, format!(" /*{comment}")));
        let _ = writeln!(text, "    {value},{comment}");
    }
    text.push_str("};\n");
}
