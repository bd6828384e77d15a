/* Vector table and start-up of a Cortex-M program with semihosting. newlib's own start-up takes command lines of 255
 * characters, and all vectors by name are longer; a small machine makes LINE_SIZE smaller. */

#include <stdint.h>
#include <stdlib.h>

extern uint32_t __stack;
extern uint32_t __bss_start__;
extern uint32_t __bss_end__;
extern void initialise_monitor_handles(void);
extern int main(int argc, char **argv);
void reset(void);

#ifndef LINE_SIZE
#define LINE_SIZE 65536
#endif

enum { SYS_GET_CMDLINE = 0x15, ARGUMENTS_MAX = LINE_SIZE / 64 };

static char line[LINE_SIZE];
static char *arguments[ARGUMENTS_MAX + 1];

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

static int semihosting(int operation, void *block)
{
    register int r0 __asm__("r0") = operation;
    register void *r1 __asm__("r1") = block;

    __asm__ volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

/* The command line cut at its spaces. */
static int split(char *rest)
{
    int count = 0;

    while (*rest != '\0' && count < ARGUMENTS_MAX) {
        arguments[count++] = rest;
        while (*rest != '\0' && *rest != ' ') {
            rest++;
        }
        while (*rest == ' ') {
            *rest++ = '\0';
        }
    }
    return count;
}

static void start(void)
{
    struct {
        char *text;
        uint32_t size;
    } block = {line, sizeof line};
    uint32_t *word;

    for (word = &__bss_start__; word != &__bss_end__; word++) {
        *word = 0;
    }
    initialise_monitor_handles();
    if (semihosting(SYS_GET_CMDLINE, &block) != 0) {
        _Exit(71);
    }
    exit(main(split(line), arguments));
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
