//! Bytes of a program as they are in the flash.

use object::elf::PT_LOAD;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, FileKind};

/// Alignment of a vector table, and so of the program after its header.
const ALIGNMENT: u32 = 512;
/// Longest program, more than any board has: an address beyond it is an error of the linker script.
const LONGEST: u32 = 16 << 20;

/// Returns the bytes that an ELF file loads, from its first address on, with gaps filled with ones; any other
/// file is returned unchanged.
///
/// # Errors
/// Fails if an ELF file is damaged, not for 32 bits, or linked to an address where no image can be.
pub(super) fn flat(file: &[u8]) -> Result<Vec<u8>, String> {
    match FileKind::parse(file) {
        Ok(FileKind::Elf32) => {}
        Ok(kind) => return Err(format!("{kind:?}: neither a 32-bit ELF file nor plain bytes")),
        Err(_) => return Ok(file.to_vec()),
    }
    let elf = ElfFile32::<Endianness>::parse(file).map_err(|error| error.to_string())?;
    let endian = elf.endian();
    let mut parts = Vec::new();
    for segment in elf.elf_program_headers() {
        if segment.p_type(endian) == PT_LOAD && segment.p_filesz(endian) > 0 {
            let bytes = segment.data(endian, file).map_err(|()| "a segment that is not in the file")?;
            parts.push((segment.p_paddr(endian), bytes));
        }
    }
    parts.sort_by_key(|(address, _)| *address);
    let Some(&(start, _)) = parts.first() else { return Err("nothing to load".into()) };
    if !start.is_multiple_of(ALIGNMENT) {
        return Err(format!(
            "linked to {start:08X}h: a program begins {ALIGNMENT} bytes behind the slot, on a multiple of that"
        ));
    }
    let mut program = Vec::new();
    for (address, bytes) in parts {
        let offset = address - start;
        if offset > LONGEST || (offset as usize) < program.len() {
            return Err(format!("a segment at {address:08X}h does not follow the one before it"));
        }
        program.resize(offset as usize, 0xFF);
        program.extend_from_slice(bytes);
    }
    Ok(program)
}
