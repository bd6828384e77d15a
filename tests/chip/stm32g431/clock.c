/* Time of the model: called by the emulator at the start of every block of instructions, in place of a callback in
   Python. It counts instructions and cycles, and stops the emulator when the next event of the chip is due, or when an
   interrupt that waits is no longer masked. */

#include <stdint.h>

struct clock {
    uint64_t time;         /* units since power-up */
    uint64_t deadline;     /* stop at this time */
    uint64_t per_cycle;    /* units of a clock of the processor */
    uint64_t instructions; /* executed since power-up */
    uint64_t block;        /* address of the block that is executed */
    uint64_t mask;         /* register PRIMASK, if an interrupt waits for it to be 0; else 0 */
    uint64_t start, end;   /* addresses of the program */
    uint64_t stack;        /* register SP */
    uint64_t lowest;       /* smallest value that it has had */
    const uint16_t *program;
    int (*stop)(void *engine);
    int (*read)(void *engine, int name, void *value);
};

void on_block(void *engine, uint64_t address, uint32_t size, struct clock *clock) {
    if (clock->time >= clock->deadline) {
        clock->stop(engine);
        return;
    }
    if (clock->mask != 0) {
        uint32_t masked = 1;
        clock->read(engine, (int)clock->mask, &masked);
        if ((masked & 1) == 0) {
            clock->stop(engine);
            return;
        }
    }
    uint32_t stack = 0;
    clock->read(engine, (int)clock->stack, &stack);
    if (stack < clock->lowest)
        clock->lowest = stack;
    /* An instruction whose first halfword begins with 0b11101 or above has 32 bits. */
    uint32_t instructions = 0;
    if (address >= clock->start && address + size <= clock->end) {
        const uint16_t *code = clock->program + (address - clock->start) / 2;
        for (uint32_t at = 0; at < size / 2; instructions++)
            at += (code[at] >> 11) >= 0x1D ? 2 : 1;
    }
    clock->block = address;
    clock->instructions += instructions;
    clock->time += (instructions + instructions / 4 + 2) * clock->per_cycle;
}
