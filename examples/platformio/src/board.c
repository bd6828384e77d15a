/* A board with nothing on it: replace each body by your registers. On this machine it runs for a second and
 * prints how many frames were sent. */

#include "board.h"

/* Frames that were sent. */
static unsigned frames;

#if defined(__x86_64__)
#include <stdio.h>

enum { TICKS = 10000 };

int board_wait(void)
{
    static unsigned waited;

    control_interrupt();
    if (++waited < TICKS) {
        return 1;
    }
    printf("narx %s: %u frames in a second\n", narx_version(), frames);
    return 0;
}
#else
int board_wait(void)
{
    __asm__ volatile("wfi");
    return 1;
}
#endif

void board_start(void)
{
}

void board_sample(narx_samples_t *samples)
{
    samples->bus_voltage = 1229; /* 24 V on the default board */
    samples->bus_current = 2048; /* none */
    samples->hall = 1;
}

void board_apply(const narx_pwm_command_t *command)
{
    (void)command;
}

int board_receive(narx_frame_t *frame)
{
    (void)frame;
    return 0;
}

void board_send(const narx_frame_t *frame)
{
    (void)frame;
    frames++;
}
