/* Vector table and first instructions for a Cortex-M4F; newlib's start-up does the rest. */

#include <stdint.h>
#include <stdlib.h>

extern uint32_t __stack;
extern void _start(void);
void reset(void);

/* Any exception ends the program: it uses none. */
static void fault(void)
{
    _Exit(70);
}

union vector {
    void (*handler)(void);
    uint32_t *stack;
};

__attribute__((section(".vectors"), used)) static const union vector vectors[16] = {
    {.stack = &__stack}, {.handler = reset}, {.handler = fault}, {.handler = fault},
    {.handler = fault},  {.handler = fault}, {.handler = fault},
};

/* The floating-point unit is off after reset (CPACR), and the calling convention passes arguments in it. */
void reset(void)
{
    volatile uint32_t *const cpacr = (volatile uint32_t *)0xE000ED88u;
    *cpacr |= 0xFu << 20;
    __asm__ volatile("dsb\n\tisb");
    _start();
}
