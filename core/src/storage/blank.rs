//! Erases flash that is not blank yet: an unnecessary erase costs time and lifetime.

use super::ring::Failed;
use core::ops::Range;
use embedded_storage_async::nor_flash::NorFlash;

/// Bytes that a flash erases at once where it can: a sector of 64 KiB takes as long as three subsectors of
/// 4 KiB.
pub(super) const SECTOR: u32 = 64 << 10;
const PIECE: usize = 256;

/// Returns whether a range is all ones.
pub(super) async fn is_blank<F: NorFlash>(flash: &mut F, range: Range<u32>) -> Result<bool, Failed> {
    let mut piece = [0; PIECE];
    let mut at = range.start;
    while at < range.end {
        let length = (range.end - at).min(PIECE as u32);
        let piece = piece.get_mut(..length as usize).unwrap_or_default();
        flash.read(at, piece).await.map_err(|_| Failed)?;
        if piece.iter().any(|byte| *byte != 0xFF) {
            return Ok(false);
        }
        at += length;
    }
    Ok(true)
}

/// Returns the piece of a range to erase next: from its front to the next border of a sector.
pub(super) fn next_piece(range: &Range<u32>) -> Range<u32> {
    let border = (range.start / SECTOR + 1) * SECTOR;
    range.start..border.min(range.end)
}

/// Erases those pieces of a range of whole subsectors that are not blank.
pub(super) async fn erase<F: NorFlash>(flash: &mut F, mut range: Range<u32>) -> Result<(), Failed> {
    while range.start < range.end {
        let piece = next_piece(&range);
        range.start = piece.end;
        if !is_blank(flash, piece.clone()).await? {
            flash.erase(piece.start, piece.end).await.map_err(|_| Failed)?;
        }
    }
    Ok(())
}
