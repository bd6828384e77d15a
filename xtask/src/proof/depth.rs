//! Bound of the stack: the frames on the longest path of calls.

use super::code::{Code, Function};
use std::collections::BTreeMap;

/// Facts that the disassembly does not show, and that were read in the sources.
pub(super) struct Known {
    /// Targets of calls of a pointer in a register, by a part of the caller's name; the first match counts.
    pub(super) pointers: &'static [(&'static str, &'static [Goes])],
    /// Largest number of times that a function can be on one path, by the end of its name. Others can be on a
    /// path again only with one of these between.
    pub(super) nested: &'static [(&'static str, usize)],
}

impl Known {
    /// No calls of pointers, and no function twice on a path.
    pub(super) const NOTHING: Self = Self { pointers: &[], nested: &[] };
}

/// Target of a call of a pointer in a register.
pub(super) enum Goes {
    /// A function whose address is in the caller's own code: it stays in a register for many calls.
    Own,
    /// Functions with this in their name.
    To(&'static str),
}

/// Largest number of bytes of stack below the caller of the function at `root`; a function whose name
/// satisfies `ends` takes none.
///
/// # Errors
/// Fails if there is no bound: a function that calls itself, an unknown target of a pointer, or a frame
/// without a fixed size.
pub(super) fn depth(code: &Code, root: u32, known: &Known, ends: fn(&str) -> bool) -> Result<u32, String> {
    Search { code, known, ends, called: BTreeMap::new(), found: BTreeMap::new(), path: Vec::new() }
        .below(root)
}

struct Search<'a> {
    code: &'a Code,
    known: &'a Known,
    ends: fn(&str) -> bool,
    /// Functions that each function calls.
    called: BTreeMap<u32, Vec<u32>>,
    /// Bytes by the function and the nested functions above it, on which they depend.
    found: BTreeMap<(u32, Vec<u32>), u32>,
    path: Vec<u32>,
}

impl Search<'_> {
    fn below(&mut self, at: u32) -> Result<u32, String> {
        let Some(function) = self.code.functions.get(&at).filter(|function| !(self.ends)(&function.name))
        else {
            return Ok(0);
        };
        let comes_back = || format!("{} may come back to itself", function.name);
        if function.calls_itself {
            return Err(comes_back());
        }
        if let Some(times) = self.times(function) {
            if self.path.iter().filter(|above| **above == at).count() >= times {
                return Ok(0);
            }
        } else if let Some(last) = self.path.iter().rposition(|above| *above == at)
            && !self.path.iter().skip(last).any(|between| self.is_nested(*between))
        {
            return Err(comes_back());
        }
        let key = (at, self.nested_above());
        if let Some(bytes) = self.found.get(&key) {
            return Ok(*bytes);
        }
        let frame = function.frame.ok_or_else(|| format!("{}: a frame of no fixed size", function.name))?;
        let called = match self.called.get(&at) {
            Some(called) => called.clone(),
            None => self.called(function)?,
        };
        self.called.insert(at, called.clone());
        self.path.push(at);
        let mut deepest = 0;
        for at in called {
            deepest = deepest.max(self.below(at)?);
        }
        self.path.pop();
        self.found.insert(key, frame + deepest);
        Ok(frame + deepest)
    }

    fn times(&self, function: &Function) -> Option<usize> {
        let fits = |(end, _): &&(&str, usize)| function.name.ends_with(end);
        self.known.nested.iter().find(fits).map(|(_, times)| *times)
    }

    fn is_nested(&self, at: u32) -> bool {
        self.code.functions.get(&at).is_some_and(|function| self.times(function).is_some())
    }

    /// Functions on the path that may be there more than once, in order of their addresses.
    fn nested_above(&self) -> Vec<u32> {
        let mut nested: Vec<u32> = self.path.iter().copied().filter(|at| self.is_nested(*at)).collect();
        nested.sort_unstable();
        nested
    }

    fn called(&self, function: &Function) -> Result<Vec<u32>, String> {
        let mut called: Vec<u32> = function.calls.iter().copied().collect();
        if !function.calls_any {
            return Ok(called);
        }
        let goes = self.known.pointers.iter().find(|(part, _)| function.name.contains(part));
        let (_, goes) = goes.ok_or_else(|| format!("{} calls what a register points at", function.name))?;
        for goes in *goes {
            match goes {
                Goes::Own => {
                    called.extend(function.addresses.iter().filter_map(|address| self.code.entry(*address)));
                }
                Goes::To(part) => called.extend(self.code.named(|name| name.contains(part))),
            }
        }
        Ok(called)
    }
}

#[cfg(test)]
mod tests {
    use super::{Goes, Known, depth};
    use crate::proof::code::Code;

    /// A loop that calls a pointer of its own and one from elsewhere; two functions that call each other.
    const TEXT: &str = "\
00000400 <background>:
     400:\tsub\tsp, #16
     402:\tmovw\tr4, #1281\t@ 0x501
     406:\tmovt\tr4, #0
     40a:\tblx\tr4
     40c:\tbl\t600 <texts>

00000500 <copied>:
     500:\tsub\tsp, #8

00000600 <texts>:
     600:\tpush\t{r4, lr}
     602:\tblx\tr3

00000700 <<Number as Display>::fmt>:
     700:\tsub\tsp, #32
     702:\tbl\t600 <texts>

00000800 <Sink>:
     800:\tsub\tsp, #4

00000900 <again>:
     900:\tsub\tsp, #4
     902:\tbls.n\t900 <again>
     904:\tbl\t900 <again>
";

    #[test]
    fn the_longest_path_counts_and_what_has_no_bound_is_named() {
        let code = Code::parse(TEXT);
        let stack = |root, known| depth(&code, root, known, |name| name == "never");
        assert_eq!(stack(0x500, &Known::NOTHING), Ok(8));
        assert_eq!(stack(0x900, &Known::NOTHING), Err("again may come back to itself".into()));
        assert_eq!(stack(0x400, &Known::NOTHING), Err("background calls what a register points at".into()));
        let once = Known {
            pointers: &[("background", &[Goes::Own]), ("texts", &[Goes::To("Display"), Goes::To("Sink")])],
            nested: &[],
        };
        assert_eq!(stack(0x400, &once), Err("texts may come back to itself".into()));
        let nested = Known { nested: &[("texts", 2)], ..once };
        assert_eq!(stack(0x400, &nested), Ok(16 + 8 + 32 + 8 + 32));
        assert_eq!(
            stack(0x700, &Known { nested: &[("Sink", 2)], ..once }),
            Err("<Number as Display>::fmt may come back to itself".into())
        );
        assert_eq!(depth(&code, 0x400, &nested, |name| name == "texts"), Ok(16 + 8));
    }
}
