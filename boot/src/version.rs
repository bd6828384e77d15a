//! Versions of images.

use core::fmt;
use core::str::FromStr;

/// Version of an image. The order is that of the fields: a build without a higher version is newer than one
/// with a lower build number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Version {
    /// Major version: the high byte of DEVICE_INFO's software release.
    pub major: u8,
    /// Minor version: its low byte.
    pub minor: u8,
    /// Patch level.
    pub patch: u16,
    /// Build number, as BUILD_INFO tells it.
    pub build: u16,
}

/// A text is no version `MAJOR.MINOR.PATCH` or `MAJOR.MINOR.PATCH+BUILD`, or one of its numbers is too large
/// (255, 255, 65535, 65535).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoVersion;

impl FromStr for Version {
    type Err = NoVersion;

    fn from_str(text: &str) -> Result<Self, NoVersion> {
        let (numbers, build) = text.split_once('+').unwrap_or((text, "0"));
        let mut numbers = numbers.split('.');
        let [major, minor, patch] = [(); 3].map(|()| numbers.next().unwrap_or_default());
        match (number(major), number(minor), number(patch), number(build), numbers.next()) {
            (Ok(major), Ok(minor), Ok(patch), Ok(build), None) => Ok(Self { major, minor, patch, build }),
            _ => Err(NoVersion),
        }
    }
}

fn number<N: FromStr>(text: &str) -> Result<N, NoVersion> {
    let digits = text.bytes().all(|byte| byte.is_ascii_digit());
    if digits { text.parse().map_err(|_| NoVersion) } else { Err(NoVersion) }
}

impl fmt::Display for Version {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { major, minor, patch, build } = self;
        write!(f, "{major}.{minor}.{patch}+{build}")
    }
}

impl fmt::Display for NoVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("not MAJOR.MINOR.PATCH or MAJOR.MINOR.PATCH+BUILD, up to 255.255.65535+65535")
    }
}

impl core::error::Error for NoVersion {}
