/* Blocks of narx by hand, for a processor without a Rust compiler, and the check that they answer the same bits: a PI controller, a ramp,
 * sectors from angles and from hall codes, and the steps of the bridge.
 *
 * It needs port_tables.h and port_vectors.h, which narx makes, and nothing else of narx: no library and no narx.h. It is C99 for an `int` of
 * 16 bits and bytes of 16, and shifts no negative number.
 */

#include <stdint.h>
#include <stdio.h>

#include "port_tables.h"
#include "port_vectors.h"

/* Largest proportional part. */
#define HEADROOM (INT64_C(1) << 47)

/* value * 2^-bits, rounded down. */
static int64_t shifted(int64_t value, int32_t bits)
{
    return value >= 0 ? value >> bits : -((-(value + 1)) >> bits) - 1;
}

static int64_t limited(int64_t value, int64_t minimum, int64_t maximum)
{
    return value < minimum ? minimum : value > maximum ? maximum : value;
}

/* gain * value, with 16 fraction bits more. A product has 62 bits at most. */
static int64_t gained(const int32_t gain[2], int32_t value)
{
    int64_t product = (int64_t)value * gain[0];

    return gain[1] >= 16 ? shifted(product, gain[1] - 16) : limited(product, -HEADROOM, HEADROOM) * ((int32_t)1 << (16 - gain[1]));
}

/* The integrator never holds more than brings the output to one of its limits. */
static int32_t pi_step(int64_t *integrator, int32_t error)
{
    const int64_t low = (int64_t)narx_port_pi_limits[0] * 65536;
    const int64_t high = (int64_t)narx_port_pi_limits[1] * 65536;
    int64_t proportional = limited(gained(narx_port_pi_gains[0], error), -HEADROOM, HEADROOM);

    *integrator = limited(*integrator + gained(narx_port_pi_gains[1], error), low - (proportional > 0 ? proportional : 0),
                          high - (proportional < 0 ? proportional : 0));
    return (int32_t)shifted(limited(*integrator + proportional, low, high), 16);
}

static int32_t ramp_step(int64_t *value, int32_t target)
{
    *value += limited((int64_t)target * 65536 - *value, -narx_port_ramp_rate, narx_port_ramp_rate);
    return (int32_t)shifted(*value, 16);
}

/* Sector s spans 30 + 60 s to 90 + 60 s degrees; 30 degrees are 5461. */
static uint16_t sector_of(uint16_t angle)
{
    return (uint16_t)((uint32_t)(uint16_t)(angle - 5461u) * 6u >> 16);
}

/* Every step switches one leg, holds another low and leaves the third off; the opposite torque is that of the opposite sector. */
static int is_step(int torque, int sector)
{
    int leg;
    int sum = 0;
    int on = 0;

    for (leg = 0; leg < 3; leg++) {
        sum += narx_port_legs[torque][sector][leg];
        on += narx_port_legs[torque][sector][leg] != 0;
        if (narx_port_legs[torque][sector][leg] != narx_port_legs[1 - torque][(sector + 3) % 6][leg]) {
            return 0;
        }
    }
    return sum == 0 && on == 2;
}

int main(void)
{
    int64_t integrator = 0;
    int64_t value = 0;
    int32_t sector = NARX_PORT_INVALID;
    int step;
    int wrong = 0;

    for (step = 0; step < NARX_PORT_STEPS; step++) {
        uint_least8_t seen = narx_port_sectors[0][narx_port_hall[step][0]];

        /* A code that no rotor gives leaves the sector as it was. */
        sector = seen == NARX_PORT_INVALID ? sector : seen;
        wrong += pi_step(&integrator, narx_port_pi[step][0]) != narx_port_pi[step][1];
        wrong += ramp_step(&value, narx_port_ramp[step][0]) != narx_port_ramp[step][1];
        wrong += sector_of(narx_port_angles[step][0]) != narx_port_angles[step][1];
        /* As long as it does not know the speed, the drive waits a tick before it believes an edge. This port does not. */
        wrong += narx_port_hall[step][3] != 0 && sector != narx_port_hall[step][1];
    }
    for (step = 0; step < 12; step++) {
        wrong += !is_step(step / 6, step % 6);
    }
    printf("%d of %d answers are wrong\n", wrong, 4 * NARX_PORT_STEPS + 12);
    return wrong == 0 ? 0 : 1;
}
