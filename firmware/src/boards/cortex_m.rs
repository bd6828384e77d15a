//! The image's own program, the RAM that it runs in and the end of its stack, as bytes and cells: for the
//! self-tests of any Cortex-M.

use core::ptr;
use narx_board::self_test::march::{Cells, march_keeping};

/// Words kept aside while their place is tested.
const KEPT: usize = 64;
/// Bytes of stack below the stack pointer for the test itself and what it calls.
const MARGIN: usize = 4096;
/// Words at the end of the stack that nobody ever writes.
const CANARY: usize = 16;

unsafe extern "C" {
    static __vector_table: u32;
    static __sidata: u32;
    static __sdata: u32;
    static __edata: u32;
}

/// The program with its constants and the first values of its variables.
pub fn program() -> &'static [u8] {
    // Where the flash begins at 0, a slice cannot: the vector table's first word, the stack pointer, is left
    // out.
    let start = (&raw const __vector_table).wrapping_add(1).cast::<u8>();
    let variables = (&raw const __edata) as usize - (&raw const __sdata) as usize;
    let end = (&raw const __sidata) as usize + variables;
    // SAFETY: the linker script's symbols enclose what the image's file has put into the flash, and nobody
    // writes there.
    unsafe { core::slice::from_raw_parts(start, end - start as usize) }
}

/// Tests the RAM from its beginning to just below the stack that is in use, and leaves everything in it as it
/// was.
///
/// The stack in use, some hundred bytes at the end, is not tested: whoever tests stands on it.
#[must_use]
pub fn is_ram_sound() -> bool {
    unsafe extern "C" {
        static _ram_start: u32;
    }
    let start = &raw const _ram_start;
    let end = cortex_m::register::msp::read() as usize - MARGIN;
    let words = (end - start as usize) / size_of::<u32>();
    cortex_m::interrupt::free(|_| march_keeping(&mut Ram { start: start.cast_mut(), words }, &mut [0; KEPT]))
}

struct Ram {
    start: *mut u32,
    words: usize,
}

impl Cells for Ram {
    fn len(&self) -> usize {
        self.words
    }

    fn read(&self, index: usize) -> u32 {
        debug_assert!(index < self.words);
        // SAFETY: a word of RAM below the stack in use. No interrupt comes meanwhile, and what lies here gets
        // its value back before anybody looks.
        unsafe { ptr::read_volatile(self.start.wrapping_add(index)) }
    }

    fn write(&mut self, index: usize, value: u32) {
        debug_assert!(index < self.words);
        // SAFETY: as above.
        unsafe { ptr::write_volatile(self.start.wrapping_add(index), value) }
    }
}

/// Returns whether the end of the stack is still as start-up has painted it.
pub fn is_stack_end_untouched() -> bool {
    unsafe extern "C" {
        static _stack_end: u32;
    }
    let end = &raw const _stack_end;
    // SAFETY: the lowest words of the stack, which are RAM that start-up has painted; they are only read.
    (0..CANARY)
        .all(|word| unsafe { ptr::read_volatile(end.wrapping_add(word)) } == cortex_m_rt::STACK_PAINT_VALUE)
}
