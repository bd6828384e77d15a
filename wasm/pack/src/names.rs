//! Names for TypeScript types, from the tables that define them.

use narx_core::bus::narmotion::{Field, MESSAGES, Meaning, SIGNALS as MEASUREMENTS};
use narx_core::commissioning::Mode;
use narx_core::dictionary::Dictionary;
use narx_core::master::{Request, UpdateStage};
use narx_core::motor::signal::DRIVE_SIGNALS;
use narx_core::motor::{FaultWord, State};
use narx_host::can_log::{message_name, node};
use narx_sim::bench::SIGNALS;
use narx_sim::plant::{Injection, Input};
use narx_sim::presets::PRESETS;
use narx_sim::replayed;
use std::fmt::{self, Write};

/// Returns the types of names in the bench's module.
pub(crate) fn bench() -> Result<String, fmt::Error> {
    let mut text = String::new();
    let signals = SIGNALS.iter().map(|signal| signal.name);
    union(&mut text, "SignalName", "Signals of a trace.", signals)?;
    union(&mut text, "MotorName", "Real motors.", PRESETS.iter().map(|preset| preset.name))?;
    union(&mut text, "Mode", "Control modes.", Mode::ALL.iter().map(|mode| mode.name()))?;
    union(&mut text, "FaultName", "Bits of the fault word.", faults())?;
    union(&mut text, "InjectionName", "Faults that can be injected.", Injection::NAMES)?;
    union(&mut text, "InputName", "Inputs of the board that are read slowly.", Input::ALL.map(Input::name))?;
    Ok(text)
}

/// Returns the types of names in the core's module.
pub(crate) fn core() -> Result<String, fmt::Error> {
    let mut text = String::new();
    union(&mut text, "FaultName", "Bits of the fault word.", faults())?;
    union(&mut text, "StateName", "States of the drive, 0 to 7.", State::ALL.map(State::name))?;
    union(&mut text, "RequestName", "Requests without a value.", Request::NAMED.map(|(name, _)| name))?;
    union(&mut text, "UpdateStage", "Stages of an update.", UpdateStage::ALL.map(UpdateStage::label))?;
    union(&mut text, "ParameterName", "Parameters of the drive.", Dictionary::rows().map(|row| row.name()))?;
    let measured = MEASUREMENTS.iter().map(|signal| signal.name);
    union(&mut text, "MeasurementName", "Signals of the measurements.", measured)?;
    let shown = DRIVE_SIGNALS.iter().map(|row| row.name);
    union(&mut text, "ScopeSignalName", "Signals of the virtual scope.", shown)?;
    drive_messages(&mut text)?;
    node_messages(&mut text)?;
    Ok(text)
}

/// Returns the types of names in the laboratory's module.
pub(crate) fn lab() -> Result<String, fmt::Error> {
    let mut text = String::new();
    let signals = replayed::SIGNALS.iter().map(|signal| signal.name);
    union(&mut text, "SignalName", "Signals of the trace of a replay.", signals)?;
    let messages = MESSAGES.iter().map(message_name);
    let messages = messages.chain(node::MESSAGES.iter().map(|message| message.name.to_owned()));
    union(&mut text, "MessageName", "Messages of the drive and of TX-Drivers.", messages)?;
    Ok(text)
}

/// Writes the types of the drive's messages.
fn drive_messages(text: &mut String) -> fmt::Result {
    write!(
        text,
        "\n/** Fields of the drive's messages, by the names of the CAN database. */\nexport interface DriveValues {{"
    )?;
    for message in &MESSAGES {
        write!(text, "\n    readonly {}: {{", message_name(message))?;
        for field in message.fields() {
            write!(text, "\n        readonly \"{}\": {};", field.name, shape(&field))?;
        }
        let end = if message.fields().next().is_some() { "\n    };" } else { "};" };
        text.push_str(end);
    }
    text.push_str("\n}\n");
    Ok(())
}

fn shape(field: &Field) -> String {
    match field.meaning {
        Meaning::Faults => "FaultName[]".to_owned(),
        Meaning::Named(names) => {
            named(names.values, field.bits < 16 && names.values.len() == 1 << field.bits)
        }
        _ => "number".to_owned(),
    }
}

/// Writes the types of the TX-Drivers' messages.
fn node_messages(text: &mut String) -> fmt::Result {
    write!(text, "\n/** Fields of the TX-Drivers' messages. */\nexport interface NodeValues {{")?;
    for (place, message) in node::MESSAGES.iter().enumerate() {
        write!(text, "\n    readonly \"{}\": {{", message.name)?;
        let signals = node::signals(place);
        for signal in &signals {
            // Signals that not every PDO carries are optional.
            let optional = if matches!(signal.name, "Position 2" | "Encoder") { "?" } else { "" };
            let shape =
                if signal.names.is_empty() { "number".to_owned() } else { named(&signal.names, false) };
            write!(text, "\n        readonly \"{}\"{optional}: {shape};", signal.name)?;
        }
        text.push_str(if signals.is_empty() { "};" } else { "\n    };" });
    }
    text.push_str("\n}\n");
    Ok(())
}

/// Returns the names, and `number` if some numbers have no name.
fn named(names: &[(u16, &str)], all: bool) -> String {
    let mut text: Vec<String> = names.iter().map(|(_, name)| format!("\"{name}\"")).collect();
    if !all {
        text.push("number".to_owned());
    }
    text.join(" | ")
}

fn faults() -> impl Iterator<Item = String> {
    FaultWord::all().iter_names().map(|(name, _)| name.to_ascii_lowercase()).collect::<Vec<_>>().into_iter()
}

fn union<T: fmt::Display>(
    text: &mut String,
    name: &str,
    about: &str,
    members: impl IntoIterator<Item = T>,
) -> fmt::Result {
    write!(text, "\n/** {about} */\nexport type {name} =")?;
    for member in members {
        write!(text, "\n    | \"{member}\"")?;
    }
    text.push_str(";\n");
    Ok(())
}
