//! Text in XML 1.0.

use core::fmt;

/// Text in which nothing can be taken for markup.
pub(super) struct Escaped<'a>(pub(super) &'a str);

const MARKUP: [char; 4] = ['&', '<', '>', '"'];

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for part in self.0.split_inclusive(MARKUP) {
            let text = part.trim_end_matches(MARKUP);
            f.write_str(text)?;
            f.write_str(match part.as_bytes().get(text.len()) {
                Some(b'&') => "&amp;",
                Some(b'<') => "&lt;",
                Some(b'>') => "&gt;",
                Some(_) => "&quot;",
                None => "",
            })?;
        }
        Ok(())
    }
}

/// The attribute `unit`, where there is one.
pub(super) struct Unit(pub(super) &'static str);

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == "-" { Ok(()) } else { write!(f, " unit=\"{}\"", Escaped(self.0)) }
    }
}
