//! Bulk downloads: the description, the scope's record, the log.

use super::narx_master_t;
use crate::handle;
use crate::pointer;
use crate::status::narx_status_t::{self, *};
use narx_core::master::{Download, DownloadError, Master};

/// Data that can be downloaded.
#[repr(u8)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum narx_download_kind_t {
    /// The description of the drive, XML; the high byte of a word comes first.
    Description = 0,
    /// The scope's record: `count` words, selected signals times samples, at most 65 536. Q3.12.
    Scope = 1,
    /// `count` records of the log from index `first` on; each has half as many words as parameter 69 has
    /// bytes.
    Log = 2,
}

/// Up to three words of a download.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct narx_chunk_t {
    /// Place of the first word in the download, words.
    pub offset: u32,
    /// Number of valid `words`.
    pub length: u8,
    /// The words.
    pub words: [u16; 3],
}

/// Begins a download: a narx_download_kind_t with its arguments, 0 for those that it does not need. Returns
/// NARX_ERROR_FULL while there is another whose result was not taken, NARX_ERROR_SILENT for a silent master,
/// NARX_ERROR_REQUEST for an undefined kind.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_download(
    master: *mut narx_master_t,
    kind: u8,
    first: u32,
    count: u32,
) -> narx_status_t {
    use narx_download_kind_t as Kind;
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        let what = match kind {
            kind if kind == Kind::Description as u8 => Download::Description,
            kind if kind == Kind::Scope as u8 => Download::Scope { words: count },
            kind if kind == Kind::Log as u8 => Download::Log { first, records: count },
            _ => return Err(NARX_ERROR_REQUEST),
        };
        Ok(master.download(what)?)
    };
    pointer::status(run())
}

/// Writes the next words of the download, or returns NARX_NOTHING. Words may come more than once, each time
/// the same.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_poll_chunk(
    master: *mut narx_master_t,
    chunk: *mut narx_chunk_t,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let next = |master: &mut Master| {
        let piece = master.poll_chunk()?;
        let mut words = [0; 3];
        for (to, from) in words.iter_mut().zip(piece.words()) {
            *to = *from;
        }
        Some(narx_chunk_t { offset: piece.offset, length: piece.words().len() as u8, words })
    };
    unsafe { handle::poll(master, chunk, next) }
}

/// Returns the result of the download, once all its chunks were taken: NARX_OK, with its length in words,
/// NARX_NOTHING before the end, or the error: NARX_ERROR_NO_ANSWER, NARX_ERROR_NO_LOG, NARX_ERROR_SPOILED,
/// NARX_ERROR_ABORTED, or the reason of the drive's refusal.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_poll_download(
    master: *mut narx_master_t,
    words: *mut u32,
) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    let run = || unsafe {
        let master = handle::object(master)?;
        pointer::check(words)?;
        let end = master.poll_download().ok_or(NARX_NOTHING)?;
        pointer::write(words, end?)
    };
    pointer::status(run())
}

/// Aborts the download; its result is NARX_ERROR_ABORTED.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn narx_master_abort_download(master: *mut narx_master_t) -> narx_status_t {
    // SAFETY: the rule for pointers at the head of narx.h.
    pointer::status(unsafe { handle::object(master) }.map(|master| master.abort_download()))
}

impl From<DownloadError> for narx_status_t {
    fn from(error: DownloadError) -> Self {
        match error {
            DownloadError::NoAnswer => NARX_ERROR_NO_ANSWER,
            DownloadError::Refused(refusal) => refusal.status.into(),
            DownloadError::NoLog => NARX_ERROR_NO_LOG,
            DownloadError::Spoiled { .. } => NARX_ERROR_SPOILED,
            DownloadError::Aborted => NARX_ERROR_ABORTED,
        }
    }
}
