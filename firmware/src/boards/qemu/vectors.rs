//! Vectors of the machine's 32 interrupts (MPS2, application note 386): a table of all that a processor may
//! have would have to stand where no slot begins.

unsafe extern "C" {
    fn DefaultHandler();
}

/// Whichever comes, one function finds out which.
// SAFETY: the linker script has it behind the processor's own vectors, and every entry is a function.
#[unsafe(link_section = ".vector_table.interrupts")]
// SAFETY: the name by which cortex-m-rt looks for it, and nobody else has one.
#[unsafe(no_mangle)]
static __INTERRUPTS: [unsafe extern "C" fn(); 32] = [DefaultHandler; 32];
