/* Speed, angle and commutation from hall sensors. It replaces a driver that commutated in the interrupt of
 * each edge, by a table of codes. Such a driver has no speed before the third edge, and does not notice an
 * edge that does not come.
 *
 * Here narx_hall_step takes the lines and their captured edges once a PWM period. narx_commutation_step
 * returns the legs to switch, and the instants within the period.
 */

#include <stdio.h>

#include "narx.h"

enum { TICKS_A_SECOND = 10000, TICKS_A_SECTOR = 25 };

/* The code of each sector, 60 degrees each, lines A, B, C in bits 0, 1, 2. */
static const uint8_t codes[6] = {1, 3, 2, 6, 4, 5};

int main(void)
{
    static narx_hall_t hall;
    static narx_commutator_t commutator;
    static const narx_commutation_settings_t advance = {0, 8192};
    narx_hall_settings_t settings;
    narx_hall_reading_t reading;
    narx_steps_t steps;
    uint8_t legs[3];
    int changes = 0;
    int tick;
    narx_step_t last = NARX_STEP_COAST;

    if (narx_hall_settings_default(&settings) != NARX_OK) {
        return 1;
    }
    settings.tick_rate = TICKS_A_SECOND;
    if (narx_hall_init(&hall, sizeof hall, &settings, NULL) != NARX_OK
        || narx_commutation_init(&commutator, sizeof commutator, &advance, NULL) != NARX_OK) {
        return 1;
    }
    for (tick = 0; tick < TICKS_A_SECOND; tick++) {
        const uint8_t code = codes[tick / TICKS_A_SECTOR % 6];
        narx_edge_t edge = {0, NARX_EDGE_SOURCE_HALL, 0};
        const size_t edges = tick % TICKS_A_SECTOR == 0 && tick != 0 ? 1 : 0;

        /* Captured in the middle of the previous period. */
        edge.instant = 0x8000;
        edge.code = code;
        if (narx_hall_step(&hall, code, &edge, edges, &reading) != NARX_OK
            || narx_commutation_step(&commutator, reading.angle, reading.turn_speed, 0, &steps) != NARX_OK) {
            return 1;
        }
        if (steps.commutation_count > 0) {
            steps.step = steps.commutations[steps.commutation_count - 1].step;
        }
        changes += steps.step != last;
        last = steps.step;
    }
    if (narx_commutation_legs(last, legs) != NARX_OK) {
        return 1;
    }
    printf("%ld mrev/s in sector %d, %d commutations in a second, legs %d%d%d\n", (long)narx_milli_from_q16(reading.speed),
           reading.sector, changes, legs[0], legs[1], legs[2]);
    /* 10 000 / (6 x 25) = 66.667 rev/s. */
    return narx_milli_from_q16(reading.speed) / 10 == 6666 && changes >= 399 && changes <= 401 && legs[0] + legs[1] + legs[2] == 3
               ? 0
               : 1;
}
