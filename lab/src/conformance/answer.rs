//! Answer of a target about one recording.

/// One line of a replayer: `STEM TICKS DIGEST RECORDED`, or with a limited number of ticks
/// `STEM TICKS DIGEST - OUTPUTS`, where OUTPUTS is the text form of `narx_core::recording::Outputs`. For a
/// recording that cannot be replayed: `STEM error MESSAGE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Number of replayed ticks.
    pub ticks: u64,
    /// Digest of the outputs.
    pub digest: u64,
    /// Digest in the file, if the replay was whole.
    pub recorded: Option<u64>,
    /// Outputs of the last tick, if the replay was limited.
    pub outputs: Option<String>,
}

impl Answer {
    /// Reads the line about `stem`.
    ///
    /// # Errors
    /// Fails with the target's own message, or with the line if it is not of this form.
    pub fn parse(stem: &str, line: &str) -> Result<Self, String> {
        let malformed = || format!("not an answer about {stem}: {line:?}");
        let rest = line.strip_prefix(stem).and_then(|rest| rest.strip_prefix(' ')).ok_or_else(malformed)?;
        if let Some(message) = rest.strip_prefix("error ") {
            return Err(message.to_owned());
        }
        let mut words = rest.splitn(4, ' ');
        let mut word = || words.next().ok_or_else(malformed);
        let ticks = word()?.parse().map_err(|_| malformed())?;
        let digest = hexadecimal(word()?).ok_or_else(malformed)?;
        let recorded = word()?;
        let outputs = word().ok().map(str::to_owned);
        let recorded = match recorded {
            "-" => None,
            digits => Some(hexadecimal(digits).ok_or_else(malformed)?),
        };
        Ok(Self { ticks, digest, recorded, outputs })
    }
}

/// Parses exactly 16 digits, so that a target that omits leading zeros is noticed.
fn hexadecimal(digits: &str) -> Option<u64> {
    (digits.len() == 16).then(|| u64::from_str_radix(digits, 16).ok()).flatten()
}
