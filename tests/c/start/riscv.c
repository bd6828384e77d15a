/* Start of a RISC-V processor, with the symbols of picolibc's linker script. */

#include "start.h"

#include <stdlib.h>
#include <string.h>

extern char __data_start[], __data_source[], __data_size[];
extern char __bss_start[], __bss_size[];
extern char __tls_base[];
extern void _set_tls(void *tls);
void start(void);

/* Any trap ends the program. */
__attribute__((aligned(4), interrupt("machine"))) static void fault(void)
{
    _Exit(70);
}

/* The emulator knows the call by the two instructions around it, which do nothing and may not be compressed. */
int semihosting(int operation, void *block)
{
    register int a0 __asm__("a0") = operation;
    register void *a1 __asm__("a1") = block;

    __asm__ volatile(
        ".option push\n\t.option norvc\n\t"
        ".balign 16\n\tslli zero, zero, 0x1f\n\tebreak\n\tsrai zero, zero, 7\n\t"
        ".option pop"
        : "+r"(a0)
        : "r"(a1)
        : "memory");
    return a0;
}

__attribute__((used)) void start(void)
{
    __asm__ volatile(".option push\n\t.option arch, +zicsr\n\tcsrw mtvec, %0\n\t.option pop" : : "r"(fault));
    memcpy(__data_start, __data_source, (size_t)__data_size);
    memset(__bss_start, 0, (size_t)__bss_size);
    _set_tls(__tls_base);
    run_program();
}

__attribute__((naked, used, section(".text.init.enter"))) void _start(void)
{
    __asm__ volatile(
        ".option push\n\t.option norelax\n\t"
        "la gp, __global_pointer$\n\tla sp, __stack\n\tj start\n\t"
        ".option pop");
}
