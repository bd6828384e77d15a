/* A motor that still turns when the drive is switched on: its speed and angle are found from the back-EMF at
 * its terminals, with the bridge off. It replaces a driver that waited until the motor had stopped.
 *
 * With the bridge on the same call finds the zero crossings of the floating phase, and the instant of the
 * next commutation (reading.commutation).
 */

#include <stdio.h>
#include <string.h>

#include "narx.h"

enum { TICKS_A_SECOND = 10000 };

/* Back-EMF of one phase, converter codes, at `angle` (2^16 a turn): a trapezoid with flat tops of
 * 120 degrees; at angle 0 it is 0 and rises. */
static int32_t emf(uint16_t angle)
{
    const int32_t x = angle < 32768 ? angle : angle - 32768; /* half a turn */
    const int32_t up = x < 5461 ? x : 5461;
    const int32_t down = 32768 - x < 5461 ? 32768 - x : 5461;
    const int32_t level = 200 * (up < down ? up : down) / 5461;

    return angle < 32768 ? level : -level;
}

int main(void)
{
    static narx_zero_crossing_t detector;
    static const narx_applied_t coasting = {0xC000, NARX_STEP_COAST, 0, {0, 0}, {0, 0}};
    narx_zero_crossing_settings_t settings;
    narx_zero_crossing_reading_t reading;
    narx_samples_t samples;
    int caught = -1;
    int tick;

    if (narx_zero_crossing_settings_default(&settings) != NARX_OK) {
        return 1;
    }
    settings.tick_rate = TICKS_A_SECOND;
    if (narx_zero_crossing_init(&detector, sizeof detector, &settings, NULL) != NARX_OK) {
        return 1;
    }
    memset(&samples, 0, sizeof samples);
    samples.bus_voltage = 1229;
    for (tick = 0; tick < TICKS_A_SECOND; tick++) {
        /* 50 electrical revolutions a second, sampled at 3/4 of each period; the star point floats at 300
         * codes. */
        const uint32_t turned = (uint32_t)tick * 65536u / 200u + 65536u * 3u / 4u / 200u;
        int phase;

        samples.tick = (uint64_t)tick;
        for (phase = 0; phase < 3; phase++) {
            samples.phase_voltage[phase] = (uint16_t)(300 + emf((uint16_t)(turned - (uint32_t)phase * 65536u / 3u)));
        }
        if (narx_zero_crossing_step(&detector, &samples, &coasting, 0, &reading) != NARX_OK) {
            return 1;
        }
        if (reading.running && caught < 0) {
            caught = tick;
        }
    }
    printf("caught in tick %d: %ld mrev/s\n", caught, (long)narx_milli_from_q16(reading.speed));
    /* The motor is found within two revolutions, its speed to one per cent. */
    return caught > 0 && caught < 600 && narx_milli_from_q16(reading.speed) > 49500 && narx_milli_from_q16(reading.speed) < 50500 ? 0 : 1;
}
