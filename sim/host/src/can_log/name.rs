//! Names of the drive's messages and signals that every tool takes: those of the CAN database, too.

use narx_core::bus::narmotion::{MESSAGES, Message, MessageKind};

/// The printed name of a message as an identifier; with its type, where several messages have the name.
pub fn message_name(message: &Message) -> String {
    let name = identifier(message.name);
    let shared = MESSAGES.iter().filter(|other| other.name == message.name).count() > 1;
    match message.kind {
        MessageKind::DataSet if shared => name + "_SET",
        MessageKind::DataRequest if shared => name + "_REQUEST",
        _ => name,
    }
}

/// Letters and digits of a name, joined by `_`.
pub fn identifier(name: &str) -> String {
    let mut joined = String::new();
    for word in name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()) {
        // An identifier does not begin with a digit.
        if !joined.is_empty() || word.starts_with(|c: char| c.is_ascii_digit()) {
            joined.push('_');
        }
        joined += word;
    }
    joined
}
