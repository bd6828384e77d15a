//! March C- (van de Goor, *Testing Semiconductor Memories*, 1991): finds every stuck cell, every cell that
//! does not change, every pair of cells of which one disturbs the other, and addresses that lead nowhere, to
//! two cells, or to another's.
//!
//! ```text
//!   up (w0)   up (r0, w1)   up (r1, w0)   down (r0, w1)   down (r1, w0)   any (r0)
//! ```
//!
//! 0 and 1 are words here. Between the bits of one word disturbances are found where they change a bit
//! against the rest, for which the march is repeated with other patterns.

/// Words of which a march makes its 0; its 1 has the other bits.
const PATTERNS: [u32; 3] = [0, 0x5555_5555, 0x3333_3333];

/// A memory that is tested.
pub trait Cells {
    /// Words.
    fn len(&self) -> usize;
    /// Word `index`, from the memory itself.
    fn read(&self, index: usize) -> u32;
    /// Writes word `index`, into the memory itself.
    fn write(&mut self, index: usize, value: u32);

    /// Returns whether there are no words to test.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Marches over `cells`, whose contents are lost; false if they are no memory.
#[must_use]
pub fn march(cells: &mut impl Cells) -> bool {
    PATTERNS.iter().all(|zero| march_with(cells, *zero))
}

/// Marches over a memory in use: block by block, what was in it kept in `kept` meanwhile and put back. Of two
/// cells that disturb each other both must lie in one block to be found. Nobody else may touch the memory,
/// and `kept` must not be part of it.
#[must_use]
pub fn march_keeping(cells: &mut impl Cells, kept: &mut [u32]) -> bool {
    let (words, step) = (cells.len(), kept.len());
    let mut start = 0;
    let mut is_sound = true;
    while is_sound && start < words && step > 0 {
        let mut block = Block { length: step.min(words - start), start, cells };
        kept.iter_mut().enumerate().take(block.length).for_each(|(index, word)| *word = block.read(index));
        is_sound = march(&mut block);
        kept.iter().enumerate().take(block.length).for_each(|(index, word)| block.write(index, *word));
        start += step;
    }
    is_sound
}

fn march_with(cells: &mut impl Cells, zero: u32) -> bool {
    let (one, end) = (!zero, cells.len());
    (0..end).for_each(|index| cells.write(index, zero));
    let mut is_sound = true;
    let mut element = |index: usize, expected: u32, next: u32| {
        is_sound &= cells.read(index) == expected;
        cells.write(index, next);
    };
    (0..end).for_each(|index| element(index, zero, one));
    (0..end).for_each(|index| element(index, one, zero));
    (0..end).rev().for_each(|index| element(index, zero, one));
    (0..end).rev().for_each(|index| element(index, one, zero));
    is_sound && (0..end).all(|index| cells.read(index) == zero)
}

struct Block<'a, C> {
    cells: &'a mut C,
    start: usize,
    length: usize,
}

impl<C: Cells> Cells for Block<'_, C> {
    fn len(&self) -> usize {
        self.length
    }

    fn read(&self, index: usize) -> u32 {
        self.cells.read(self.start + index)
    }

    fn write(&mut self, index: usize, value: u32) {
        self.cells.write(self.start + index, value);
    }
}
