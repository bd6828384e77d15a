//! Frames as they stand in a log, as columns.

/// Flags of a frame, beside identifier and data: a bit each.
pub mod flag {
    /// 29-bit identifier.
    pub const EXTENDED: u8 = 1;
    /// Remote frame.
    pub const REMOTE: u8 = 1 << 1;
    /// Error frame.
    pub const ERROR: u8 = 1 << 2;
    /// CAN FD.
    pub const FD: u8 = 1 << 3;
    /// Not sent by the one who has logged it.
    pub const RECEIVED: u8 = 1 << 4;
    /// CAN FD with a switched bit rate.
    pub const BITRATE_SWITCH: u8 = 1 << 5;
    /// CAN FD from a node that is error passive.
    pub const ERROR_STATE: u8 = 1 << 6;

    /// Every flag with its name.
    pub const ALL: [(&str, u8); 7] = [
        ("extended", EXTENDED),
        ("remote", REMOTE),
        ("error", ERROR),
        ("fd", FD),
        ("received", RECEIVED),
        ("bitrate_switch", BITRATE_SWITCH),
        ("error_state", ERROR_STATE),
    ];
}

/// One frame of a log.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Logged<'a> {
    /// Time as it was stamped, s.
    pub time: f64,
    /// Place of its channel in [`Frames::channels`].
    pub channel: u16,
    /// Bits of [`flag`].
    pub flags: u8,
    /// The identifier.
    pub id: u32,
    /// Bytes that it has, or as a remote frame asks for.
    pub dlc: u8,
    /// The bytes, up to 64; a remote frame has none.
    pub data: &'a [u8],
}

/// Columns of the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frames {
    /// Time as it was stamped, s.
    pub time: Vec<f64>,
    /// Identifier.
    pub id: Vec<u32>,
    /// Bits of [`flag`].
    pub flags: Vec<u8>,
    /// Place of the channel in `channels`.
    pub channel: Vec<u16>,
    /// Bytes that a frame has, or as a remote frame asks for.
    pub dlc: Vec<u8>,
    /// Its message: the place of a table, or what [`super::Kind`] says.
    pub message: Vec<u8>,
    /// The first 8 data bytes, zeros behind the last one.
    pub data: Vec<[u8; 8]>,
    /// Rows with more than 8 bytes, and all of those.
    pub long: Vec<(usize, Box<[u8]>)>,
    /// Names of the channels.
    pub channels: Vec<String>,
}

impl Frames {
    /// The place of a channel of this name.
    pub fn channel(&mut self, name: &str) -> u16 {
        let place = self.channels.iter().position(|known| known == name).unwrap_or_else(|| {
            self.channels.push(name.to_owned());
            self.channels.len() - 1
        });
        // Beyond 65 535 channels they share the last place.
        u16::try_from(place).unwrap_or(u16::MAX)
    }

    pub(super) fn push(&mut self, logged: &Logged<'_>, message: u8) {
        let mut first = [0; 8];
        first.iter_mut().zip(logged.data).for_each(|(byte, data)| *byte = *data);
        if logged.data.len() > first.len() {
            self.long.push((self.time.len(), logged.data.into()));
        }
        self.time.push(logged.time);
        self.id.push(logged.id);
        self.flags.push(logged.flags);
        self.channel.push(logged.channel);
        self.dlc.push(logged.dlc);
        self.message.push(message);
        self.data.push(first);
    }

    pub(super) fn append(&mut self, mut other: Self) {
        let channels: Vec<u16> = other.channels.iter().map(|name| self.channel(name)).collect();
        if channels.iter().enumerate().any(|(place, here)| place != usize::from(*here)) {
            for channel in &mut other.channel {
                *channel = channels.get(usize::from(*channel)).copied().unwrap_or(u16::MAX);
            }
        }
        let rows = self.time.len();
        self.long.extend(other.long.into_iter().map(|(row, data)| (rows + row, data)));
        self.time.append(&mut other.time);
        self.id.append(&mut other.id);
        self.flags.append(&mut other.flags);
        self.channel.append(&mut other.channel);
        self.dlc.append(&mut other.dlc);
        self.message.append(&mut other.message);
        self.data.append(&mut other.data);
    }
}
