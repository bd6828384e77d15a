/* The ticks of tick.c driving a motor: samples of a simulated one come line by line, and a command goes back for each.
 *
 * Usage: turn hall|sensorless MILLIHERTZ MILLIVOLT, the electrical speed that it shall hold, and the voltage with which it takes over. In: `BUS_VOLTAGE
 * BUS_CURRENT PHASE_A PHASE_B PHASE_C HALL EDGE EDGE_AT`, as in `struct samples`; out: `DUTY STEP AT NEXT`, as in `struct command`.
 */
#define main count_main
#include "tick.c"
#undef main

#include <string.h>

int main(int count, char **arguments)
{
    unsigned bus, current, phase[3], code, edge, at;
    struct command out = {0};
    struct drive d;
    tick *step;

    if (count != 4) {
        return 2;
    }
    step = strcmp(arguments[1], "hall") == 0 ? hall : sensorless;
    d = running((uint32_t)atol(arguments[2]), (int32_t)atol(arguments[3]));
    while (scanf("%u %u %u %u %u %u %u %u", &bus, &current, &phase[A], &phase[B], &phase[C], &code, &edge, &at) == 8) {
        struct samples in = {
            .bus_voltage = (uint16_t)bus,
            .bus_current = (uint16_t)current,
            .phase_voltage = {(uint16_t)phase[A], (uint16_t)phase[B], (uint16_t)phase[C]},
            .hall = (uint8_t)code,
            .edge = edge != 0,
            .edge_at = (uint16_t)at,
        };

        step(&d, &in, &out);
        printf("%u %u %u %u\n", out.duty, out.step, out.at, out.next);
        fflush(stdout);
    }
    return 0;
}
