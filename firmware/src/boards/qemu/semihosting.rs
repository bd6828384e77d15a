//! The host of the emulator, seen from the image: arguments, files, output and exit code.
//! (Arm, *Semihosting for AArch32 and AArch64*, operations of the same names.)

use core::ffi::CStr;
use core::fmt::{self, Write as _};
use cortex_m_semihosting::{debug, nr, syscall1};
use heapless::{String, Vec};

/// Bytes of a path at most, its end mark included.
const PATH_MAX: usize = 1024;

/// A file of the host that cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileError {
    /// Its path is longer than 1023 bytes.
    PathTooLong,
    /// It does not open.
    NotFound,
    /// It is longer than the buffer.
    TooLong {
        /// Its bytes.
        length: usize,
        /// Bytes of the buffer.
        room: usize,
    },
    /// Reading stopped before its end.
    Unreadable,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PathTooLong => write!(f, "its path is longer than {} bytes", PATH_MAX - 1),
            Self::NotFound => write!(f, "cannot be opened"),
            Self::TooLong { length, room } => {
                write!(f, "has {length} bytes, and the image has room for {room}")
            }
            Self::Unreadable => write!(f, "cannot be read to its end"),
        }
    }
}

/// The arguments behind the program's name, split at spaces; nothing if they do not fit in `line`.
pub fn arguments(line: &mut [u8]) -> impl Iterator<Item = &str> {
    let mut block = [line.as_mut_ptr() as usize, line.len()];
    // SAFETY: GET_CMDLINE writes at most the second word's number of bytes to the address in the first word,
    // which is `line`, and the length into the block.
    let failed = unsafe { operation(nr::GET_CMDLINE, &mut block) } != 0;
    let length = if failed { 0 } else { block[1] };
    let text = line.get(..length).and_then(|bytes| core::str::from_utf8(bytes).ok()).unwrap_or("");
    text.split(['\0', ' ']).filter(|word| !word.is_empty()).skip(1)
}

/// Prints a text by nothing but the host's operation: from an interrupt that nobody can mask, too.
pub fn print(text: &CStr) {
    // SAFETY: WRITE0 reads from there to the zero behind the text.
    unsafe { syscall1!(WRITE0, text.as_ptr()) };
}

/// Prints a line of 62 bytes at most; of a longer one nothing. Unlike `hprintln!` it keeps no handle for all,
/// whose lock could panic.
pub fn print_line(text: fmt::Arguments<'_>) {
    let mut line = String::<64>::new();
    if write!(line, "{text}\n\0").is_ok()
        && let Ok(line) = CStr::from_bytes_until_nul(line.as_bytes())
    {
        print(line);
    }
}

/// Reads a whole file into `buffer`.
///
/// # Errors
/// It does not open, does not fit, or cannot be read.
pub fn read_file<'b>(path: &str, buffer: &'b mut [u8]) -> Result<&'b [u8], FileError> {
    let mut name = Vec::<u8, PATH_MAX>::new();
    name.extend_from_slice(path.as_bytes())
        .and_then(|()| name.extend_from_slice(&[0]))
        .map_err(|_| FileError::PathTooLong)?;
    let mut block = [name.as_ptr() as usize, nr::open::R_BINARY, path.len()];
    // SAFETY: OPEN reads a string with an end mark from the address in the first word.
    let handle = unsafe { operation(nr::OPEN, &mut block) };
    if handle == usize::MAX {
        return Err(FileError::NotFound);
    }
    let content = read_open(handle, buffer);
    // SAFETY: CLOSE reads the handle from its block.
    unsafe { operation(nr::CLOSE, &mut [handle]) };
    content
}

/// Ends the emulator: exit code 0 or 1.
pub fn exit(success: bool) -> ! {
    loop {
        debug::exit(if success { debug::EXIT_SUCCESS } else { debug::EXIT_FAILURE });
    }
}

fn read_open(handle: usize, buffer: &mut [u8]) -> Result<&[u8], FileError> {
    // SAFETY: FLEN reads the handle from its block.
    let length = unsafe { operation(nr::FLEN, &mut [handle]) };
    let room = buffer.len();
    let content = buffer.get_mut(..length).ok_or(FileError::TooLong { length, room })?;
    // SAFETY: READ writes at most the third word's number of bytes to the address in the second word, which
    // is `content`.
    let missing = unsafe { operation(nr::READ, &mut [handle, content.as_mut_ptr() as usize, length]) };
    if missing == 0 { Ok(content) } else { Err(FileError::Unreadable) }
}

/// Asks the host for operation `number`.
///
/// # Safety
/// `block` is what the operation wants, and what its addresses point at may be read and written as it does.
unsafe fn operation<const WORDS: usize>(number: usize, block: &mut [usize; WORDS]) -> usize {
    // SAFETY: the caller's.
    unsafe { syscall1(number, block.as_mut_ptr() as usize) }
}
