/* Vector table and start of a Cortex-M. */

#include "start.h"

#include <stdint.h>
#include <stdlib.h>

extern uint32_t __stack;
extern uint32_t __bss_start__;
extern uint32_t __bss_end__;
extern void initialise_monitor_handles(void);
void reset(void);

/* Any exception ends the program, but the one that a program may use as its control interrupt. */
static void fault(void)
{
    _Exit(70);
}

void pend_sv(void) __attribute__((weak, alias("fault")));

union vector {
    void (*handler)(void);
    uint32_t *stack;
};

__attribute__((section(".vectors"), used)) static const union vector vectors[16] = {
    {.stack = &__stack}, {.handler = reset}, {.handler = fault}, {.handler = fault},
    {.handler = fault},  {.handler = fault}, {.handler = fault}, {.handler = fault},
    {.handler = fault},  {.handler = fault}, {.handler = fault}, {.handler = fault},
    {.handler = fault},  {.handler = fault}, {.handler = pend_sv}, {.handler = fault},
};

int semihosting(int operation, void *block)
{
    register int r0 __asm__("r0") = operation;
    register void *r1 __asm__("r1") = block;

    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static void start(void)
{
    uint32_t *word;

    for (word = &__bss_start__; word != &__bss_end__; word++) {
        *word = 0;
    }
    initialise_monitor_handles();
    run_program();
}

/* The floating-point unit is off after reset (CPACR), and the calling convention passes arguments in it. */
void reset(void)
{
#ifdef __ARM_FP
    volatile uint32_t *const cpacr = (volatile uint32_t *)0xE000ED88u;

    *cpacr |= 0xFu << 20;
    __asm__ volatile("dsb\n\tisb");
#endif
    start();
}
