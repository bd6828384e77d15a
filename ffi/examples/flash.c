/* Parameters that survive a power cut, and the log: a drive on a serial NOR flash. It replaces a hand-written
 * settings page with a check sum. The chip here is memory. On a board the three functions send your chip's
 * commands (03h, 06h 02h, 06h 20h) and wait for its busy bit. */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "narx.h"

#define SIZE (512u * 1024u)

static uint8_t chip[SIZE];

static int32_t chip_read(void *context, uint32_t address, uint8_t *bytes, size_t length)
{
    const uint8_t *from = context;

    memcpy(bytes, from + address, length);
    return 0;
}

/* Programs within one page. */
static int32_t chip_program(void *context, uint32_t address, const uint8_t *bytes, size_t length)
{
    uint8_t *to = context;
    size_t k;

    for (k = 0; k < length; k++) {
        to[address + k] &= bytes[k];
    }
    return 0;
}

/* Erases whole subsectors. */
static int32_t chip_erase(void *context, uint32_t from, uint32_t to)
{
    uint8_t *bytes = context;

    memset(bytes + from, 0xFF, to - from);
    return 0;
}

static const narx_flash_t flash = {SIZE, chip, chip_read, chip_program, chip_erase};
static narx_storage_t storage;
static narx_drive_t drive;

static void power_up(void)
{
    if (narx_storage_init(&storage, sizeof storage, &flash) != NARX_OK
        || narx_storage_init_drive(&storage, &drive, sizeof drive, NULL, NULL) != NARX_OK) {
        exit(EXIT_FAILURE);
    }
}

/* Runs the control interrupt and the main loop up to tick `end`. */
static void run(uint64_t *now, uint64_t end)
{
    narx_samples_t samples;
    narx_pwm_command_t command;

    memset(&samples, 0, sizeof samples);
    samples.bus_voltage = 1229;
    samples.bus_current = 2048;
    samples.hall = 1;
    for (; *now < end; ++*now) {
        samples.tick = *now;
        (void)narx_drive_step(&drive, &samples, &command);
        (void)narx_drive_run(&drive, *now);
        (void)narx_storage_serve(&storage, &drive);
    }
}

int main(void)
{
    uint64_t now = 0;
    int32_t pole_pairs = 0;

    memset(chip, 0xFF, sizeof chip);
    power_up();
    run(&now, 6000);
    (void)narx_drive_set_parameter(&drive, NARX_PARAMETER_MOTOR_POLE_PAIRS, 7);
    (void)narx_drive_set_parameter(&drive, NARX_PARAMETER_STORE, 0);
    (void)narx_drive_set_parameter(&drive, NARX_PARAMETER_STORE, 1);
    run(&now, 7000);

    /* A power cut, and the next power-up. */
    power_up();
    (void)narx_drive_get_parameter(&drive, NARX_PARAMETER_MOTOR_POLE_PAIRS, &pole_pairs);
    printf("%ld pole pairs after the power came back\n", (long)pole_pairs);
    return pole_pairs == 7 ? 0 : 1;
}
