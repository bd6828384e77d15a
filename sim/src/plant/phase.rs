//! The motor's three phases, by which its arrays of three are.

use core::ops::{Index, IndexMut};

/// A phase, a leg or a hall line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Phase {
    /// A.
    A,
    /// B.
    B,
    /// C.
    C,
}

impl Phase {
    /// All three.
    pub const ALL: [Self; 3] = [Self::A, Self::B, Self::C];

    /// 0, 1 or 2. Where a phase is kept in another enumeration the compiler forgets that there are no others:
    /// then the bound stays, as one instruction instead of a panic.
    pub const fn index(self) -> usize {
        let index = self as usize;
        if index < 2 { index } else { 2 }
    }

    /// The two others, in the order A, B, C, A.
    pub(crate) const fn others(self) -> [Self; 2] {
        match self {
            Self::A => [Self::B, Self::C],
            Self::B => [Self::C, Self::A],
            Self::C => [Self::A, Self::B],
        }
    }
}

impl<T> Index<Phase> for [T; 3] {
    type Output = T;

    #[inline]
    fn index(&self, phase: Phase) -> &T {
        &self[phase.index()]
    }
}

impl<T> IndexMut<Phase> for [T; 3] {
    #[inline]
    fn index_mut(&mut self, phase: Phase) -> &mut T {
        &mut self[phase.index()]
    }
}
