/* A TX-Driver and its master: a node with eddy-current sensors on eddyCAN, and the device that reads the
 * shaft's displacement from it. The loop here exchanges their frames; `displacement` replaces the
 * converter. */

#include <stdio.h>

#include "narx.h"

static narx_tx_driver_t node;
static narx_tx_master_t master;
static const narx_tx_layout_t single = {1, 0};

/* A shaft that runs 20 um out of true, a turn in 3.6 ms, as a triangle; 2^-27 mm. */
static int32_t displacement(uint64_t now)
{
    const int32_t place = (int32_t)(now % 3600u) - 1800;
    const int32_t micrometre = (1 << 27) / 1000;

    return ((place < 0 ? -place : place) - 900) * (20 * micrometre / 900);
}

/* Samples the sensor every 100 us. Writes the smallest and the largest position that the master has received
 * to `least` and `most`. */
static void run(uint64_t *now, uint64_t end, int32_t *least, int32_t *most)
{
    narx_tx_node_report_t received;
    narx_frame_t frame;

    for (; *now < end; *now += 100) {
        (void)narx_tx_driver_handle_sample(&node, displacement(*now), 0, 0);
        while (narx_tx_master_poll_frame(&master, *now, &frame) == NARX_OK) {
            (void)narx_tx_driver_handle_frame(&node, &frame, *now);
        }
        (void)narx_tx_driver_poll(&node, *now);
        while (narx_tx_driver_poll_frame(&node, &frame) == NARX_OK) {
            (void)narx_tx_master_handle_frame(&master, &frame, *now);
        }
        if (narx_tx_master_report(&master, *now, &received) == NARX_OK && received.at != UINT64_MAX) {
            *least = received.positions[0] < *least ? received.positions[0] : *least;
            *most = received.positions[0] > *most ? received.positions[0] : *most;
        }
    }
}

int main(void)
{
    /* One channel of +-1 mm, sampled at 10 kHz. */
    static const narx_tx_variant_t variant = {1, 0x0100, 10000, {-(1 << 27), 0}, {1 << 27, 0}};
    const int32_t micrometre = (1 << 27) / 1000;
    int32_t least = INT32_MAX;
    int32_t most = INT32_MIN;
    uint64_t now = 0;

    if (narx_tx_driver_init(&node, sizeof node, &variant, NULL) != NARX_OK
        || narx_tx_master_init(&master, sizeof master, 1, &single) != NARX_OK) {
        return 1;
    }
    /* A position every millisecond, then Operational. */
    (void)narx_tx_master_write(&master, NARX_TX_ENTRY_UPDATE_TIME, 1);
    run(&now, 20000, &least, &most);
    (void)narx_tx_master_command(&master, 1, 0);
    run(&now, 120000, &least, &most);
    printf("%ld to %ld um\n", (long)(least / micrometre), (long)(most / micrometre));
    return least < -17 * micrometre && most > 17 * micrometre && most < 21 * micrometre ? 0 : 1;
}
