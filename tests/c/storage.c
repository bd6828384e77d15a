/* A drive's flash from C: a NOR flash in memory that watches its rules. Parameters and log outlive the power, what a cut leaves is one set or the
 * other, and a flash that is not there is a fault that mends. Prints `N passed, N failed`. */

#include <stdint.h>
#include <string.h>

#include "check.h"
#include "narx.h"

#define FLASH_SIZE (512u * 1024u)
#define BROKEN ((int32_t)-1)

/* The chip: its bytes, and for how many more calls that change it the power lasts. */
struct chip {
    uint8_t bytes[FLASH_SIZE];
    int32_t absent;
    long lasts;
    long changes;
    long offences;
};

static struct chip chip;
static narx_storage_t storage;
static narx_drive_t drive;
static uint64_t now;

static int32_t chip_read(void *context, uint32_t address, uint8_t *bytes, size_t length)
{
    const struct chip *from = context;

    if (from->absent) {
        return BROKEN;
    }
    memcpy(bytes, from->bytes + address, length);
    return 0;
}

static int32_t chip_changes(struct chip *at)
{
    if (at->absent || at->lasts == 0) {
        return BROKEN;
    }
    at->lasts--;
    at->changes++;
    return 0;
}

static int32_t chip_program(void *context, uint32_t address, const uint8_t *bytes, size_t length)
{
    struct chip *to = context;
    size_t k;

    to->offences += address / NARX_FLASH_PAGE != (address + length - 1) / NARX_FLASH_PAGE || length == 0;
    to->offences += address + length > FLASH_SIZE;
    if (chip_changes(to) != 0) {
        return BROKEN;
    }
    for (k = 0; k < length; k++) {
        to->bytes[address + k] &= bytes[k];
    }
    return 0;
}

static int32_t chip_erase(void *context, uint32_t from, uint32_t to)
{
    struct chip *of = context;

    of->offences += from % NARX_FLASH_SUBSECTOR != 0 || to % NARX_FLASH_SUBSECTOR != 0 || from >= to || to > FLASH_SIZE;
    if (chip_changes(of) != 0) {
        return BROKEN;
    }
    memset(of->bytes + from, 0xFF, to - from);
    return 0;
}

static const narx_flash_t flash = {FLASH_SIZE, &chip, chip_read, chip_program, chip_erase};

static int32_t parameter(uint16_t number)
{
    int32_t value = -1;

    CHECK_QUIETLY(narx_drive_get_parameter(&drive, number, &value) == NARX_OK);
    return value;
}

/* A board at rest at 24 V, its main loop once a millisecond. */
static void pass(int milliseconds)
{
    narx_samples_t samples;
    narx_pwm_command_t command;
    narx_frame_t frame;
    int k;

    memset(&samples, 0, sizeof samples);
    samples.bus_voltage = 1229;
    samples.bus_current = 2048;
    samples.hall = 1;
    for (k = 0; k < 10 * milliseconds; k++) {
        samples.tick = ++now;
        CHECK_QUIETLY(narx_drive_step(&drive, &samples, &command) == NARX_OK);
        if (now % 10 == 0) {
            narx_status_t served;

            CHECK_QUIETLY(narx_drive_run(&drive, now) == NARX_OK);
            served = narx_storage_serve(&storage, &drive);
            CHECK_QUIETLY(served == NARX_OK || served == NARX_NOTHING);
            while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) {
            }
        }
    }
}

/* Power-up, up to Standby or Fault. */
static void power_up(void)
{
    memset(&storage, 0, sizeof storage);
    memset(&drive, 0, sizeof drive);
    chip.lasts = 1000000;
    now = 0;
    CHECK_QUIETLY(narx_storage_init(&storage, sizeof storage, &flash) == NARX_OK);
    CHECK_QUIETLY(narx_storage_init_drive(&storage, &drive, sizeof drive, NULL, NULL) == NARX_OK);
    pass(600);
}

/* Stores are a second apart. */
static void store(void)
{
    CHECK_QUIETLY(narx_drive_set_parameter(&drive, NARX_PARAMETER_STORE, 0) == NARX_OK);
    CHECK_QUIETLY(narx_drive_set_parameter(&drive, NARX_PARAMETER_STORE, 1) == NARX_OK);
    pass(1050);
}

static void parameters_outlive_the_power(void)
{
    memset(chip.bytes, 0xFF, sizeof chip.bytes);
    power_up();
    CHECK(chip.changes == 0 && parameter(NARX_PARAMETER_MEMORY_MAPPING_FLAG) == 0);
    CHECK(narx_drive_set_parameter(&drive, NARX_PARAMETER_MOTOR_POLE_PAIRS, 7) == NARX_OK);
    store();
    CHECK(parameter(NARX_PARAMETER_MEMORY_MAPPING_FLAG) == 1);
    power_up();
    CHECK(parameter(NARX_PARAMETER_MOTOR_POLE_PAIRS) == 7 && parameter(NARX_PARAMETER_MEMORY_MAPPING_FLAG) == 1);
}

static void a_log_outlives_the_power(void)
{
    int32_t written;

    /* What was on the chip before is nobody's log: it is full until it is erased. */
    CHECK(parameter(NARX_PARAMETER_LOG_MEMORY_FULL) == 1);
    CHECK(narx_drive_set_parameter(&drive, NARX_PARAMETER_LOG_ERASE_REQUEST, 0) == NARX_OK);
    CHECK(narx_drive_set_parameter(&drive, NARX_PARAMETER_LOG_ERASE_REQUEST, 1) == NARX_OK);
    pass(1000);
    CHECK(parameter(NARX_PARAMETER_LOG_MEMORY_FULL) == 0);
    CHECK(narx_drive_set_parameter(&drive, NARX_PARAMETER_LOG_PERIOD, 10) == NARX_OK);
    CHECK(narx_drive_set_parameter(&drive, NARX_PARAMETER_LOGGING_SLOT_FIRST, NARX_PARAMETER_DRIVE_STATE) == NARX_OK);
    store();
    CHECK(narx_drive_set_parameter(&drive, NARX_PARAMETER_LOGGING_SLOT_FIRST, 65535) == NARX_OK);
    store();
    written = parameter(NARX_PARAMETER_LOG_WRITE_INDEX);
    CHECK(written >= 50);
    power_up();
    CHECK(parameter(NARX_PARAMETER_LOG_WRITE_INDEX) == written);
}

/* The power fails before each of the changes that a store makes: the old set or the new one. */
static void a_cut_leaves_one_set_or_the_other(void)
{
    long after;
    int old = 0;
    int fresh = 0;

    CHECK(narx_drive_set_parameter(&drive, NARX_PARAMETER_MOTOR_POLE_PAIRS, 5) == NARX_OK);
    store();
    for (after = 0; fresh < 2; after++) {
        int32_t found;

        CHECK_QUIETLY(narx_drive_set_parameter(&drive, NARX_PARAMETER_MOTOR_POLE_PAIRS, 6) == NARX_OK);
        chip.lasts = after;
        store();
        power_up();
        found = parameter(NARX_PARAMETER_MOTOR_POLE_PAIRS);
        CHECK_QUIETLY(found == 5 || found == 6);
        CHECK_QUIETLY(parameter(NARX_PARAMETER_MEMORY_MAPPING_FLAG) == 1);
        old += found == 5;
        fresh += found == 6;
        if (after > 100) {
            break;
        }
        CHECK_QUIETLY(narx_drive_set_parameter(&drive, NARX_PARAMETER_MOTOR_POLE_PAIRS, 5) == NARX_OK);
        store();
    }
    CHECK(old > 0 && fresh == 2);
}

static void a_flash_that_is_not_there_is_a_fault_and_mends(void)
{
    chip.absent = 1;
    power_up();
    CHECK(parameter(NARX_PARAMETER_EXTENDED_FAULT_CODE) >> 8 == 30);
    CHECK(parameter(NARX_PARAMETER_MOTOR_POLE_PAIRS) != 7);
    chip.absent = 0;
    pass(2500);
    power_up();
    CHECK(parameter(NARX_PARAMETER_EXTENDED_FAULT_CODE) == 0);
}

static void arguments_are_checked(void)
{
    static narx_storage_t blank;
    narx_flash_t other = flash;

    CHECK(narx_storage_size() <= sizeof storage);
    CHECK(narx_storage_init(NULL, sizeof storage, &flash) == NARX_ERROR_NULL);
    CHECK(narx_storage_init(&blank, sizeof blank, NULL) == NARX_ERROR_NULL);
    CHECK(narx_storage_init(&blank, narx_storage_size() - 1, &flash) == NARX_ERROR_SIZE);
    other.erase = NULL;
    CHECK(narx_storage_init(&blank, sizeof blank, &other) == NARX_ERROR_NULL);
    CHECK(narx_storage_init_drive(&blank, &drive, sizeof drive, NULL, NULL) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_storage_init_drive(NULL, &drive, sizeof drive, NULL, NULL) == NARX_ERROR_NULL);
    CHECK(narx_storage_init_drive(&storage, NULL, sizeof drive, NULL, NULL) == NARX_ERROR_NULL);
    CHECK(narx_storage_serve(&blank, &drive) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_storage_serve(NULL, &drive) == NARX_ERROR_NULL);
    CHECK(narx_storage_serve(&storage, NULL) == NARX_ERROR_NULL);
    /* A flash of no size that a layout fits in is one that is not there. */
    other = flash;
    other.size = 100;
    CHECK(narx_storage_init(&blank, sizeof blank, &other) == NARX_OK);
    CHECK(narx_storage_init_drive(&blank, &drive, sizeof drive, NULL, NULL) == NARX_OK);
}

int main(void)
{
    parameters_outlive_the_power();
    a_log_outlives_the_power();
    a_cut_leaves_one_set_or_the_other();
    a_flash_that_is_not_there_is_a_fault_and_mends();
    arguments_are_checked();
    CHECK(chip.changes > 0 && chip.offences == 0);
    return report_checks();
}
