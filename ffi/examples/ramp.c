/* A set-point that must not jump. It replaces code that moved by whole counts, so that slow ramps did not
 * move at all:
 *
 *     if (setpoint < target) setpoint += RATE / STEPS_A_SECOND;
 */

#include <stdio.h>

#include "narx.h"

enum { STEPS_A_SECOND = 10000 };

int main(void)
{
    static narx_ramp_t ramp;
    const narx_ramp_settings_t settings = {NARX_Q16_ONE / 2, STEPS_A_SECOND}; /* half a rev/s in a second */
    int32_t value = 0;
    int step;

    if (narx_ramp_init(&ramp, sizeof ramp, &settings, NULL) != NARX_OK) {
        return 1;
    }
    for (step = 0; step < STEPS_A_SECOND; step++) {
        if (narx_ramp_step(&ramp, 100 * NARX_Q16_ONE, &value) != NARX_OK) {
            return 1;
        }
    }
    printf("%ld mrev/s after a second\n", (long)narx_milli_from_q16(value));
    if (narx_milli_from_q16(value) != 500) {
        return 1;
    }
    /* The ramp continues from a value that something else has set. */
    if (narx_ramp_set(&ramp, 20 * NARX_Q16_ONE) != NARX_OK || narx_ramp_step(&ramp, 0, &value) != NARX_OK) {
        return 1;
    }
    return value < 20 * NARX_Q16_ONE && value > 19 * NARX_Q16_ONE ? 0 : 1;
}
