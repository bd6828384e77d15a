//! Memory that holds only the subsectors that were ever written, and how often each was erased.

use super::{Memory, SUBSECTOR};
use alloc::collections::BTreeMap;
use alloc::vec;
use alloc::vec::Vec;

/// Sparse memory; its clone is an image of the flash.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sparse {
    held: BTreeMap<u32, Vec<u8>>,
    wear: BTreeMap<u32, u32>,
}

impl Sparse {
    /// All ones.
    pub const fn new() -> Self {
        Self { held: BTreeMap::new(), wear: BTreeMap::new() }
    }

    /// First address and bytes of every subsector that is not all ones.
    pub fn subsectors(&self) -> impl Iterator<Item = (u32, &[u8])> {
        let written = self.held.iter().filter(|(_, bytes)| bytes.iter().any(|byte| *byte != 0xFF));
        written.map(|(subsector, bytes)| (subsector * SUBSECTOR, bytes.as_slice()))
    }

    /// Erases of the subsector at `address`.
    pub fn wear(&self, address: u32) -> u32 {
        self.wear.get(&(address / SUBSECTOR)).copied().unwrap_or(0)
    }

    /// Erases of the most erased subsector.
    pub fn wear_max(&self) -> u32 {
        self.wear.values().copied().max().unwrap_or(0)
    }
}

impl Memory for Sparse {
    fn read(&self, address: u32, bytes: &mut [u8]) {
        let mut at = address;
        let mut rest = bytes;
        while !rest.is_empty() {
            let offset = (at % SUBSECTOR) as usize;
            let length = rest.len().min(SUBSECTOR as usize - offset);
            let (now, later) = rest.split_at_mut(length);
            match self.held.get(&(at / SUBSECTOR)).and_then(|held| held.get(offset..offset + length)) {
                Some(held) => now.copy_from_slice(held),
                None => now.fill(0xFF),
            }
            at += length as u32;
            rest = later;
        }
    }

    fn set(&mut self, address: u32, byte: u8) {
        let held = self.held.entry(address / SUBSECTOR).or_insert_with(|| vec![0xFF; SUBSECTOR as usize]);
        if let Some(held) = held.get_mut((address % SUBSECTOR) as usize) {
            *held = byte;
        }
    }

    fn clear(&mut self, from: u32, to: u32) {
        let mut at = from;
        while at < to {
            let subsector = at / SUBSECTOR;
            let end = ((subsector + 1) * SUBSECTOR).min(to);
            // An erase counts where it begins; it is told in parts.
            *self.wear.entry(subsector).or_insert(0) += u32::from(at.is_multiple_of(SUBSECTOR));
            if end - at == SUBSECTOR {
                self.held.remove(&subsector);
            } else if let Some(held) = self.held.get_mut(&subsector) {
                let range = (at % SUBSECTOR) as usize..((end - 1) % SUBSECTOR + 1) as usize;
                held.get_mut(range).into_iter().for_each(|part| part.fill(0xFF));
            }
            at = end;
        }
    }
}
