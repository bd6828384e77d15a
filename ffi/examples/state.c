/* The eight states of a drive, for a driver whose `switch` has grown over ten years. The machine reports each
 * change of state; your code sets bridge and set-points in each state. */

#include <stdio.h>
#include <string.h>

#include "narx.h"

static narx_state_machine_t machine;
static narx_state_inputs_t inputs;

/* Runs ticks until the next change, at most a second; returns the state after it. */
static int next(void)
{
    narx_change_t change;
    int tick;

    for (tick = 0; tick < 10000; tick++) {
        const narx_status_t status = narx_state_step(&machine, &inputs, &change);

        if (status == NARX_OK) {
            printf("after %4d ticks: %d -> %d\n", tick + 1, change.from, change.to);
            return change.to;
        }
        if (status != NARX_NOTHING) {
            return -1;
        }
        /* The master repeats its request. */
        if (tick % 500 == 0 && inputs.stopped == 0) {
            (void)narx_state_handle_command(&machine, 1, 50 * NARX_Q16_ONE);
        }
    }
    return -1;
}

int main(void)
{
    narx_state_settings_t settings;
    narx_state_report_t report;

    memset(&inputs, 0, sizeof inputs);
    inputs.parameters_fit = 1;
    inputs.causes_gone = 1;
    inputs.stopped = 1;
    if (narx_state_settings_default(&settings) != NARX_OK
        || narx_state_init(&machine, sizeof machine, &settings, NULL) != NARX_OK) {
        return 1;
    }
    if (next() != NARX_STATE_STANDBY) {
        return 1;
    }
    /* A start needs a Standby before it: a Drive request that has lasted since power-up does not start the
     * motor. */
    if (narx_state_handle_command(&machine, 0, 0) != NARX_OK
        || narx_state_handle_command(&machine, 2, 50 * NARX_Q16_ONE) != NARX_OK || next() != NARX_STATE_HALL_CLOSED_LOOP) {
        return 1;
    }
    if (narx_state_report(&machine, &report) != NARX_OK || report.direction != 1) {
        return 1;
    }
    /* A master that stops sending is a fault. */
    if (next() != NARX_STATE_FAULT) {
        return 1;
    }
    if (narx_state_handle_command(&machine, 0, 0) != NARX_OK || next() != NARX_STATE_STANDBY) {
        return 1;
    }
    return 0;
}
