/* A board with nothing on it: replace each body by your registers. */

#include "board.h"

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
