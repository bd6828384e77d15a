/* What the emulator calls too often for Python: the time of every block of instructions, and the frames of exceptions. */

#include <stdint.h>

struct engine {
    uint64_t time;         /* units since power-up */
    uint64_t deadline;     /* stop at this time */
    uint64_t per_cycle;    /* units of a clock of the processor */
    uint64_t instructions; /* executed since power-up */
    uint64_t block;        /* address of the block that is executed */
    uint64_t watches_mask; /* an interrupt waits for PRIMASK to be 0 */
    uint64_t start, end;   /* addresses of the program */
    uint64_t lowest;       /* smallest value that the stack pointer has had */
    uint64_t cause;        /* number of the emulator's exception that has stopped it; 0 if none has */
    uint64_t event;        /* event register: SEV, or an exception, since the last WFE (B1.5.18) */
    uint64_t ram, size;    /* address of the RAM, and its bytes */
    const uint16_t *program;
    uint32_t *memory; /* of the RAM */
    int (*stop)(void *emulator);
    int (*read)(void *emulator, int name, void *value);
    int (*write)(void *emulator, int name, const void *value);
    /* Names of registers: of a frame in its order (r0 to r3, r12, lr), and s0 to s15, fpscr. */
    int32_t sp, xpsr, control, primask, frame[6], floats[17];
};

enum { BASIC_WORDS = 8, FLOAT_WORDS = 18, FPCA = 1 << 2, ALIGNED = 1 << 9, THUMB = 1 << 24, SEV = 0xBF40 };

static uint32_t get(void *emulator, const struct engine *engine, int name) {
    uint32_t value = 0;
    engine->read(emulator, name, &value);
    return value;
}

static void set(void *emulator, const struct engine *engine, int name, uint32_t value) {
    engine->write(emulator, name, &value);
}

/* At the start of every block. It counts instructions and cycles, and stops the emulator when the next event of the chip
   is due, or when an interrupt that waits is no longer masked. */
void on_block(void *emulator, uint64_t address, uint32_t size, struct engine *engine) {
    if (engine->time >= engine->deadline) {
        engine->stop(emulator);
        return;
    }
    if (engine->watches_mask && (get(emulator, engine, engine->primask) & 1) == 0) {
        engine->stop(emulator);
        return;
    }
    uint32_t stack = get(emulator, engine, engine->sp);
    if (stack < engine->lowest)
        engine->lowest = stack;
    /* An instruction whose first halfword begins with 0b11101 or above has 32 bits. */
    uint32_t instructions = 0;
    if (address >= engine->start && address + size <= engine->end) {
        const uint16_t *code = engine->program + (address - engine->start) / 2;
        for (uint32_t at = 0; at < size / 2; instructions++) {
            if (code[at] == SEV)
                engine->event = 1;
            at += (code[at] >> 11) >= 0x1D ? 2 : 1;
        }
    }
    engine->block = address;
    engine->instructions += instructions;
    engine->time += (instructions + instructions / 4 + 2) * engine->per_cycle;
}

void on_interrupt(void *emulator, uint32_t number, struct engine *engine) {
    engine->cause = number;
    engine->stop(emulator);
}

static int is_in_ram(const struct engine *engine, uint64_t start, uint64_t end) {
    return start >= engine->ram && end <= engine->ram + engine->size;
}

/* Stacks the frame of an exception that interrupts `pc` (B1.5.6). 1 if the frame has floating-point registers, 0 if it has
   none, -1 if the stack is not in the RAM. */
int stack_frame(void *emulator, struct engine *engine, uint32_t pc) {
    engine->event = 1;
    uint32_t stack = get(emulator, engine, engine->sp);
    uint32_t control = get(emulator, engine, engine->control);
    int has_floats = (control & FPCA) != 0;
    if (!is_in_ram(engine, (uint64_t)stack - 4 * (BASIC_WORDS + FLOAT_WORDS + 1), stack))
        return -1;
    uint32_t *words = engine->memory + ((stack & ~7u) - engine->ram) / 4;
    if (has_floats) {
        words -= FLOAT_WORDS;
        for (int index = 0; index < FLOAT_WORDS - 1; index++)
            words[index] = get(emulator, engine, engine->floats[index]);
        words[FLOAT_WORDS - 1] = 0;
        set(emulator, engine, engine->control, control & ~(uint32_t)FPCA);
    }
    words -= BASIC_WORDS;
    for (int index = 0; index < 6; index++)
        words[index] = get(emulator, engine, engine->frame[index]);
    words[6] = pc;
    words[7] = (get(emulator, engine, engine->xpsr) & ~(uint32_t)ALIGNED) | (stack & 4 ? ALIGNED : 0) | THUMB;
    set(emulator, engine, engine->sp, (uint32_t)(engine->ram + 4 * (words - engine->memory)));
    return has_floats;
}

/* Takes back the frame of an exception that ends (B1.5.8). Returns where the program goes on, 0 if the stack is not in
   the RAM. */
uint32_t unstack_frame(void *emulator, struct engine *engine, int has_floats) {
    engine->event = 1;
    uint32_t stack = get(emulator, engine, engine->sp);
    uint32_t control = get(emulator, engine, engine->control);
    if (!is_in_ram(engine, stack, (uint64_t)stack + 4 * (BASIC_WORDS + (has_floats ? FLOAT_WORDS : 0))))
        return 0;
    const uint32_t *words = engine->memory + (stack - engine->ram) / 4;
    for (int index = 0; index < 6; index++)
        set(emulator, engine, engine->frame[index], words[index]);
    uint32_t pc = words[6], status = words[7];
    words += BASIC_WORDS;
    if (has_floats) {
        for (int index = 0; index < FLOAT_WORDS - 1; index++)
            set(emulator, engine, engine->floats[index], words[index]);
        words += FLOAT_WORDS;
    }
    set(emulator, engine, engine->control, has_floats ? control | FPCA : control & ~(uint32_t)FPCA);
    stack = (uint32_t)(engine->ram + 4 * (words - engine->memory));
    set(emulator, engine, engine->sp, stack + (status & ALIGNED ? 4 : 0));
    set(emulator, engine, engine->xpsr, status & ~(uint32_t)ALIGNED);
    return pc;
}
