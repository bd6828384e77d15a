//! What a target says of one recording.

/// One line of a replayer: `STEM TICKS DIGEST RECORDED`, or with a limited number of ticks
/// `STEM TICKS DIGEST - OUTPUTS`, where OUTPUTS is how `narx_core::recording::Outputs` displays itself. A recording that
/// cannot be replayed: `STEM error MESSAGE`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// Ticks replayed.
    pub ticks: u64,
    /// Digest of the outputs.
    pub digest: u64,
    /// Digest in the file, of a whole replay.
    pub recorded: Option<u64>,
    /// What the last tick answered, of a limited replay.
    pub outputs: Option<String>,
}

impl Answer {
    /// Reads the line about `stem`.
    ///
    /// # Errors
    /// The target's own message, or the line if it is not of this form.
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

/// 16 digits, so that a target that forgets leading zeros is noticed.
fn hexadecimal(digits: &str) -> Option<u64> {
    (digits.len() == 16).then(|| u64::from_str_radix(digits, 16).ok()).flatten()
}
