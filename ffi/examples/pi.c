/* A speed loop of an old drive with narx_pi_t in place of its own PI controller, which was:
 *
 *     integral += (ki * error) >> 15;
 *     if (integral > LIMIT) integral = LIMIT;              the integrator winds up behind its own limit
 *     output = ((kp * error) >> 15) + integral;
 *     if (output > LIMIT) output = LIMIT;
 *
 * The gains stay as they were, in Q15; errors and outputs are Q16.
 */

#include <stdio.h>

#include "narx.h"

enum { STEPS_A_SECOND = 1000 };

/* A motor whose speed follows its voltage with a time constant of 100 ms: rev/s for V, both Q16. */
static int32_t motor(int32_t *speed, int32_t voltage)
{
    *speed = narx_q16_add(*speed, narx_q16_subtract(narx_q16_multiply(voltage, 2 * NARX_Q16_ONE), *speed) / 100);
    return *speed;
}

int main(void)
{
    static narx_pi_t pi;
    narx_pi_settings_t settings;
    narx_setting_error_t error;
    const int32_t target = 10 * NARX_Q16_ONE;
    int32_t speed = 0;
    int32_t highest = 0;
    int step;

    settings.proportional.mantissa = 16384; /* 0.5 V for a rev/s, Q15 */
    settings.proportional.shift = 15;
    settings.integral.mantissa = 5 * NARX_IQ24_ONE; /* 5 V for a rev/s in a second, IQ24 */
    settings.integral.shift = 24;
    settings.step_rate = STEPS_A_SECOND;
    settings.minimum = 0;
    settings.maximum = 6 * NARX_Q16_ONE;
    if (narx_pi_init(&pi, sizeof pi, &settings, &error) != NARX_OK) {
        printf("%s: %ld is not within %ld to %ld %s\n", error.setting, (long)error.value, (long)error.min, (long)error.max,
               error.unit);
        return 1;
    }
    for (step = 0; step < 3 * STEPS_A_SECOND; step++) {
        int32_t voltage;

        if (narx_pi_step(&pi, narx_q16_subtract(target, speed), &voltage) != NARX_OK) {
            return 1;
        }
        motor(&speed, voltage);
        highest = speed > highest ? speed : highest;
    }
    printf("%ld mrev/s of 10000, at most %ld\n", (long)narx_milli_from_q16(speed), (long)narx_milli_from_q16(highest));
    /* The target is reached with hardly any overshoot, although the voltage was at its limit for a long
     * time. */
    return speed > target - 66 && speed < target + 66 && highest < target + target / 20 ? 0 : 1;
}
