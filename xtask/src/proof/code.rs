//! A linked program as its disassembler shows it: functions, their calls, and the stack that each uses.

use narx_report::steps::output;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

/// Disassembler; the package of the C compiler contains it.
const DISASSEMBLER: &str = "arm-none-eabi-objdump";

/// A function.
#[derive(Debug, Default)]
pub(super) struct Function {
    /// Name as in the source; generic functions share a name.
    pub(super) name: String,
    /// Start addresses of the functions that it calls or branches to.
    pub(super) calls: BTreeSet<u32>,
    /// True if it calls a pointer in a register.
    pub(super) calls_any: bool,
    /// True if it calls itself.
    pub(super) calls_itself: bool,
    /// Numbers in its code that may be addresses of functions.
    pub(super) addresses: BTreeSet<u32>,
    /// Largest number of bytes by which it lowers the stack pointer; `None` if that depends on a register.
    pub(super) frame: Option<u32>,
    /// Its first instruction on the floating-point registers, even if it only copies.
    pub(super) float: Option<String>,
}

/// Functions by their start addresses.
#[derive(Debug, Default)]
pub(super) struct Code {
    /// All functions, including those of the compiler's library.
    pub(super) functions: BTreeMap<u32, Function>,
    /// Functions whose addresses are constants: tables of methods. The processor alone enters the vectors of
    /// interrupts: callers must name those as roots.
    pub(super) tables: BTreeSet<u32>,
}

impl Code {
    /// Disassembles a program of a Cortex-M.
    ///
    /// # Errors
    /// Fails with the disassembler's message.
    pub(super) fn read(elf: &Path) -> Result<Self, String> {
        let mut objdump = Command::new(DISASSEMBLER);
        let text = output(objdump.args(["--disassemble", "--demangle", "--no-show-raw-insn"]).arg(elf))?;
        let mut code = Self::parse(&text);
        let mut objdump = Command::new(DISASSEMBLER);
        let constants = output(objdump.args(["--full-contents"]).arg(elf))?;
        code.tables = words(&constants).filter_map(|word| code.entry(word)).collect();
        if code.functions.is_empty() { Err(format!("{}: no functions", elf.display())) } else { Ok(code) }
    }

    pub(super) fn parse(text: &str) -> Self {
        let mut functions = BTreeMap::new();
        let mut at = None;
        for line in text.lines() {
            if let Some((start, name)) = head(line) {
                let function = Function { name: name.to_owned(), frame: Some(0), ..Function::default() };
                functions.insert(start, function);
                at = Some((start, Held::default()));
            } else if let Some((start, held)) = &mut at
                && !is_fill(line)
                && let Some((operation, operands)) = instruction(line)
                && let Some(function) = functions.get_mut(start)
            {
                function.take(operation, operands, held);
                function.calls_itself |= is_call(operation) && target(operands) == Some(*start);
            }
        }
        let mut code = Self { functions, tables: BTreeSet::new() };
        code.resolve();
        code
    }

    /// Converts branches into functions to calls of these, and removes branches within the own function.
    fn resolve(&mut self) {
        let starts: Vec<u32> = self.functions.keys().copied().collect();
        let start = |place: u32| starts[..starts.partition_point(|start| *start <= place)].last().copied();
        for (at, function) in &mut self.functions {
            let places = std::mem::take(&mut function.calls);
            function.calls = places.into_iter().filter_map(start).filter(|called| called != at).collect();
        }
    }

    /// Function that a pointer of this value enters: the lowest bit marks Thumb code.
    pub(super) fn entry(&self, pointer: u32) -> Option<u32> {
        (pointer & 1 == 1 && self.functions.contains_key(&(pointer - 1))).then(|| pointer - 1)
    }

    /// Start addresses of the functions whose names satisfy `is`.
    pub(super) fn named(&self, is: impl Fn(&str) -> bool) -> Vec<u32> {
        self.functions.iter().filter(|(_, function)| is(&function.name)).map(|(at, _)| *at).collect()
    }

    /// Functions that may run once one of `roots` runs. A call of a pointer may go to every function whose
    /// address is a constant, or is in the code of a function that may run. The search does not go beyond a
    /// function whose name satisfies `ends`.
    pub(super) fn reachable(&self, roots: &[u32], ends: impl Fn(&str) -> bool) -> BTreeMap<u32, &Function> {
        let mut reached = BTreeMap::new();
        let mut open = roots.to_vec();
        let (mut any, mut pointed) = (false, Vec::new());
        while let Some(at) = open.pop() {
            let Some(function) = self.functions.get(&at).filter(|_| !reached.contains_key(&at)) else {
                continue;
            };
            reached.insert(at, function);
            if ends(&function.name) {
                continue;
            }
            open.extend(&function.calls);
            pointed.extend(function.addresses.iter().filter_map(|address| self.entry(*address)));
            if function.calls_any && !any {
                any = true;
                open.extend(&self.tables);
            }
            if any {
                open.append(&mut pointed);
            }
        }
        reached
    }
}

/// Values in registers, by the registers' names.
#[derive(Default)]
struct Held {
    /// Lower halves of numbers.
    halves: BTreeMap<String, u32>,
    /// Values for the stack pointer: largest number of bytes by which they lower it.
    pointers: BTreeMap<String, u32>,
}

impl Held {
    /// Takes an instruction.
    fn take(&mut self, kind: &str, operands: &str) {
        let register = operands.split([',', ' ']).next().unwrap_or_default().to_owned();
        let lowers = match kind {
            // Clears the lowest bits of a copy of the stack pointer: a frame that begins at a multiple of
            // more than 8.
            "bfc" => immediate(operands).map(|bits| 1 << bits),
            // The end of such a function computes the stack pointer from its frame pointer, and raises it.
            "sub" | "subw" if operands.contains(", r7, #") => Some(0),
            _ => None,
        };
        match lowers {
            Some(bytes) => drop(self.pointers.insert(register, bytes)),
            None => drop(self.pointers.remove(&register)),
        }
    }
}

impl Function {
    /// Takes an instruction; `held` has the values in registers.
    fn take(&mut self, operation: &str, operands: &str, held: &mut Held) {
        let kind = operation.split('.').next().unwrap_or(operation);
        let register = operands.split([',', ' ']).next().unwrap_or_default();
        if is_branch(kind) {
            match target(operands) {
                Some(place) => drop(self.calls.insert(place)),
                None if register != "lr" => self.calls_any = true,
                None => {}
            }
        } else if operation == ".word" {
            self.addresses.extend(number(register));
        } else if kind == "movw" {
            held.halves.extend(immediate(operands).map(|low| (register.to_owned(), low)));
        } else if kind == "movt" {
            let low = held.halves.get(register).copied().unwrap_or(0);
            self.addresses.extend(immediate(operands).map(|high| high << 16 | low));
        } else if kind.starts_with('v') {
            self.float.get_or_insert_with(|| format!("{operation} {operands}"));
        }
        if loads_the_counter(kind, operands) {
            self.calls_any = true;
        }
        let copied = operands.strip_prefix("sp, ").and_then(|from| held.pointers.get(from));
        let lowered = copied
            .filter(|_| kind == "mov")
            .map_or_else(|| lowered(kind, operands), |bytes| Some(Some(*bytes)));
        if let Some(bytes) = lowered {
            self.frame = self.frame.zip(bytes).map(|(frame, bytes)| frame + bytes);
        }
        held.take(kind, operands);
    }
}

/// Parses `00000470 <name>:`.
fn head(line: &str) -> Option<(u32, &str)> {
    let (start, name) = line.strip_suffix(">:")?.split_once(" <")?;
    Some((u32::from_str_radix(start, 16).ok()?, name))
}

/// Returns whether a line is the linker's filler between functions: d4d4, which the disassembler shows as a
/// branch to 84 bytes before it.
fn is_fill(line: &str) -> bool {
    let place = line.split_once(':').and_then(|(place, _)| u32::from_str_radix(place.trim(), 16).ok());
    let branch = instruction(line).filter(|(operation, _)| *operation == "bmi.n");
    place.zip(branch).is_some_and(|(place, (_, operands))| target(operands) == place.checked_sub(84))
}

/// Parses `    16402:<tab>bl<tab>2074 <name>`, without the comment after it.
fn instruction(line: &str) -> Option<(&str, &str)> {
    let mut columns = line.split('\t').skip(1);
    let operation = columns.next()?.trim();
    let operands = columns.next().unwrap_or_default();
    Some((operation, operands.split(" @").next().unwrap_or_default().trim()))
}

/// Returns whether an operation is a branch that returns.
fn is_call(operation: &str) -> bool {
    let kind = operation.split('.').next().unwrap_or(operation);
    is_branch(kind) && kind.starts_with("bl") && !["ble", "bls", "blt"].contains(&kind)
}

/// Returns whether an operation is a branch, with or without condition, link and change of state.
fn is_branch(kind: &str) -> bool {
    const CONDITIONS: [&str; 15] =
        ["", "eq", "ne", "cs", "cc", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le"];
    let condition = kind.strip_prefix("blx").or(kind.strip_prefix("bl")).or(kind.strip_prefix("bx"));
    let is_linked = condition.is_some_and(|condition| CONDITIONS.contains(&condition));
    is_linked
        || ["cbz", "cbnz"].contains(&kind)
        || kind.strip_prefix('b').is_some_and(|condition| CONDITIONS.contains(&condition))
}

/// Address that a branch names.
fn target(operands: &str) -> Option<u32> {
    let (place, _) = operands.split_once(" <")?;
    u32::from_str_radix(place.rsplit(' ').next()?, 16).ok()
}

/// Parses `0x1234`.
fn number(text: &str) -> Option<u32> {
    u32::from_str_radix(text.strip_prefix("0x")?, 16).ok()
}

/// Parses the number after `#`.
fn immediate(operands: &str) -> Option<u32> {
    operands.rsplit_once('#')?.1.parse().ok()
}

/// Returns whether an instruction loads the program counter and so jumps; from the stack it is a return.
fn loads_the_counter(kind: &str, operands: &str) -> bool {
    let from = operands.strip_prefix("pc, ");
    from.is_some_and(|from| kind == "mov" || (kind.starts_with("ldr") && !from.starts_with("[sp")))
}

/// Number of bytes by which an instruction lowers the stack pointer, if it does; `Some(None)` if that depends
/// on a register.
fn lowered(kind: &str, operands: &str) -> Option<Option<u32>> {
    let from = operands.strip_prefix("sp, ");
    match kind {
        "push" => Some(Some(4 * registers(operands))),
        "vpush" => Some(Some(if operands.contains('d') { 8 } else { 4 } * registers(operands))),
        "stmdb" if operands.starts_with("sp!") => Some(Some(4 * registers(operands))),
        "str" | "strd" if operands.ends_with("]!") && operands.contains("[sp, #-") => {
            let bytes = operands.trim_end_matches("]!").rsplit_once("#-")?.1;
            Some(bytes.parse().ok())
        }
        // The end of a function that computes the stack pointer from its frame pointer raises it.
        "sub" | "subw" | "subs" if from.is_some_and(|from| !from.starts_with("r7")) => {
            Some(immediate(operands))
        }
        "mov" if from.is_some() => Some(None),
        _ => None,
    }
}

/// Number of registers in a list: `{r4, r5, lr}`, `{d8-d9}`.
fn registers(operands: &str) -> u32 {
    let list = operands.trim_start_matches("sp!, ").trim_matches(['{', '}']);
    let digits = |name: &str| name.trim_start_matches(|c: char| !c.is_ascii_digit()).parse::<u32>().ok();
    let count = |names: &str| match names.split_once('-') {
        Some((first, last)) => digits(last).zip(digits(first)).map_or(1, |(last, first)| last - first + 1),
        None => 1,
    };
    list.split(", ").map(count).sum()
}

/// Words of the sections with constants, as the disassembler prints them.
fn words(contents: &str) -> impl Iterator<Item = u32> {
    let mut constants = false;
    contents.lines().flat_map(move |line| {
        if let Some(section) = line.strip_prefix("Contents of section ") {
            constants = [".rodata", ".data"].iter().any(|name| section.starts_with(name));
        }
        let groups =
            line.strip_prefix(' ').filter(|_| constants).map_or("", |line| line.get(..41).unwrap_or(line));
        groups
            .split(' ')
            .skip(1)
            .filter_map(|word| u32::from_str_radix(word, 16).ok().map(u32::swap_bytes))
            .collect::<Vec<_>>()
    })
}

#[cfg(test)]
mod tests {
    use super::{Code, words};

    /// An interrupt that calls, branches to another function and jumps by a table; a function of which only
    /// the address is used; a function that calls itself through another.
    const TEXT: &str = "\
00000400 <interrupt>:
     400:\tpush\t{r4, r5, r7, lr}
     402:\tsub\tsp, #16
     404:\tcbz\tr0, 408 <interrupt+0x8>
     406:\tbl\t500 <work>
     408:\tb.w\t600 <rest>
     40c:\t.word\t0x00000701

00000500 <work>:
     500:\tstrd\tr4, r5, [sp, #-8]!
     504:\tmovw\tr0, #1793\t@ 0x701
     508:\tmovt\tr0, #0
     50c:\tvadd.f32\ts0, s1, s2
     510:\tbx\tlr

00000600 <rest>:
     600:\tblx\tr3
     602:\tpop\t{r4, pc}

00000700 <pointed>:
     700:\tbeq.n\t700 <pointed>
     702:\tbl\t700 <pointed>
     704:\tvpush\t{d8-d9}
     708:\tbl\t800 <again>

00000800 <again>:
     800:\tpush\t{r4, lr}
     802:\tbl\t700 <pointed>
";

    fn names(code: &Code, root: u32) -> Vec<&str> {
        code.reachable(&[root], |_| false).values().map(|function| function.name.as_str()).collect()
    }

    #[test]
    fn calls_and_pointers_lead_on() {
        let code = Code::parse(TEXT);
        assert_eq!(names(&code, 0x400), ["interrupt", "work", "rest", "pointed", "again"]);
        assert_eq!(names(&code, 0x500), ["work"], "a pointer that nobody calls by leads nowhere");
        assert!(code.functions[&0x600].calls_any && !code.functions[&0x500].calls_any);
        assert_eq!(code.functions[&0x500].float.as_deref(), Some("vadd.f32 s0, s1, s2"));
        assert_eq!(code.functions[&0x400].float, None);
    }

    #[test]
    fn what_fills_a_gap_calls_nothing() {
        let code = Code::parse(
            &TEXT.replace(" 602:\tpop\t{r4, pc}", " 602:\tpop\t{r4, pc}\n     604:\tbmi.n\t5b0 <work+0xb0>"),
        );
        assert_eq!(code.functions[&0x600].calls.len(), 0);
        let branch = Code::parse(&TEXT.replace("cbz\tr0, 408 <interrupt+0x8>", "bmi.n\t500 <work>"));
        assert!(branch.functions[&0x400].calls.contains(&0x500));
    }

    #[test]
    fn frames_add_up() {
        let code = Code::parse(TEXT);
        assert_eq!(code.functions[&0x400].frame, Some(4 * 4 + 16));
        assert_eq!(code.functions[&0x700].frame, Some(16));
        let aligned = "00000400 <aligned>:\n 400:\tsub.w\tsp, sp, #572\t@ 0x23c\n 404:\tmov\tr4, sp\n 406:\tbfc\tr4, #0, #5\n \
                       40a:\tmov\tsp, r4\n 40c:\tsub.w\tr4, r7, #28\n 410:\tmov\tsp, r4\n";
        assert_eq!(Code::parse(aligned).functions[&0x400].frame, Some(572 + 32));
        let unknown = aligned.replace("bfc\tr4, #0, #5", "sub.w\tr4, r4, r1");
        assert_eq!(Code::parse(&unknown).functions[&0x400].frame, None);
    }

    #[test]
    fn constants_are_read_as_words() {
        let text = "\nContents of section .text:\n 0400 01070000                             ....\n\
                    Contents of section .vector_table:\n 0000 01050000                             ....\n\
                    Contents of section .rodata:\n 0900 01070000 ffffffff                    ........\n";
        assert_eq!(words(text).collect::<Vec<_>>(), [0x701, u32::MAX]);
    }
}
