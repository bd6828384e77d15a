/* Drives in static memory: power-up, a start by CAN frames until the hall closed loop turns the motor, a stop; and every
 * misuse that can be seen is an error code. Prints `N passed, N failed`. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "narx.h"

/* Two drives, so that one can be seen to leave the other alone. */
static narx_drive_t drives[2];
static narx_drive_t *const drive = &drives[0];
static narx_drive_t *const bystander = &drives[1];

static int32_t parameter(narx_drive_t *of, uint16_t number)
{
    int32_t value = -1;

    CHECK(narx_drive_get_parameter(of, number, &value) == NARX_OK);
    return value;
}

static narx_frame_t request_word(uint8_t mode)
{
    narx_frame_t frame = {0x0AAD5202u, 1, 0, 8, {0}};

    frame.data[3] = mode;
    return frame;
}

/* A board at rest: 24 V on the bus (19.531 mV a code), no current, rotor in sector 0. */
static narx_samples_t at_rest(void)
{
    narx_samples_t samples;

    memset(&samples, 0, sizeof samples);
    samples.bus_voltage = 1229;
    samples.bus_current = 2048;
    samples.hall = 1;
    return samples;
}

/* What `run` has seen. */
struct seen {
    long steps;
    long commutations;
    long frames;
    long bad_frames;
    long errors;
    uint16_t duty_max;
    narx_step_t last;
};

/* Ticks with a rotor that turns a sector every 6 ms while it is driven (417 rpm, just below the least set-point of
 * 500 rpm), and draws 2 A times the duty. A request arrives every 20 ms. */
static struct seen run(uint64_t *tick, int ticks, uint8_t mode)
{
    static const uint8_t code_of_sector[6] = {1, 3, 2, 6, 4, 5};
    struct seen seen = {0, 0, 0, 0, 0, 0, NARX_STEP_COAST};
    narx_samples_t samples = at_rest();
    narx_pwm_command_t command;
    narx_frame_t frame;
    uint16_t duty = 0;
    int turned = 0;
    int k;

    for (k = 0; k < ticks; k++, ++*tick) {
        samples.tick = *tick;
        samples.edge_count = 0;
        if (seen.last != NARX_STEP_COAST && ++turned % 60 == 0) {
            samples.hall = code_of_sector[turned / 60 % 6];
            samples.edge_count = 1;
            samples.edges[0].instant = 0x8000;
            samples.edges[0].source = NARX_EDGE_SOURCE_HALL;
            samples.edges[0].code = samples.hall;
        }
        /* 8 mA a code. */
        samples.bus_current = (uint16_t)(2048 + (seen.last == NARX_STEP_COAST ? 0 : duty * 250L / 32768));
        seen.errors += narx_drive_step(drive, &samples, &command) != NARX_OK;
        seen.steps += command.step != seen.last || command.commutation_count != 0;
        seen.commutations += command.commutation_count;
        seen.last = command.step;
        duty = command.duty;
        seen.duty_max = command.duty > seen.duty_max ? command.duty : seen.duty_max;
        samples.edge_count = 0;
        samples.bus_current = 2048;
        seen.errors += narx_drive_step(bystander, &samples, &command) != NARX_OK;
        seen.errors += command.step != NARX_STEP_COAST || command.duty != 0;

        if (*tick % 200 == 0) {
            frame = request_word(mode);
            seen.errors += narx_drive_handle_frame(drive, &frame) != NARX_OK;
        }
        seen.errors += narx_drive_run(drive, *tick) != NARX_OK;
        seen.errors += narx_drive_run(bystander, *tick) != NARX_OK;
        while (narx_drive_poll_frame(drive, &frame) == NARX_OK) {
            seen.frames++;
            seen.bad_frames += !frame.extended || frame.remote || frame.length != 8;
        }
        while (narx_drive_poll_frame(bystander, &frame) == NARX_OK) {
        }
    }
    return seen;
}

static void a_motor_starts_and_stops(void)
{
    uint64_t tick = 0;
    struct seen seen;

    CHECK(narx_drive_init(drive, sizeof *drive, NULL) == NARX_OK);
    CHECK(narx_drive_init(bystander, sizeof *bystander, NULL) == NARX_OK);
    CHECK(parameter(drive, NARX_PARAMETER_DRIVE_STATE) == NARX_STATE_INITIALIZATION);

    seen = run(&tick, 10000, 0);
    CHECK(parameter(drive, NARX_PARAMETER_DRIVE_STATE) == NARX_STATE_STANDBY);
    CHECK(seen.errors == 0 && seen.steps == 0 && seen.duty_max == 0);
    CHECK(narx_drive_set_parameter(drive, NARX_PARAMETER_SENSORLESS_ENABLE, 0) == NARX_OK);
    CHECK(narx_drive_set_parameter(drive, NARX_PARAMETER_HALL_ENABLE, 1) == NARX_OK);

    seen = run(&tick, 10000, 1);
    CHECK(parameter(drive, NARX_PARAMETER_DRIVE_STATE) == NARX_STATE_HALL_CLOSED_LOOP);
    CHECK(seen.errors == 0 && seen.bad_frames == 0);
    CHECK(seen.frames > 100);
    CHECK(seen.duty_max > 0 && seen.duty_max <= 32768);
    CHECK(seen.last != NARX_STEP_COAST);
    CHECK(seen.steps > 100);
    CHECK(seen.commutations > 0);
    CHECK(parameter(bystander, NARX_PARAMETER_DRIVE_STATE) == NARX_STATE_STANDBY);
    /* A mode is chosen at rest. */
    CHECK(narx_drive_set_parameter(drive, NARX_PARAMETER_SLAVE_CAN_ADDRESS, 3) == NARX_ERROR_WRONG_STATE);

    seen = run(&tick, 10000, 0);
    CHECK(parameter(drive, NARX_PARAMETER_DRIVE_STATE) == NARX_STATE_STANDBY);
    CHECK(seen.errors == 0 && seen.last == NARX_STEP_COAST);
}

/* The description, asked for and read to its end. */
static void a_description_is_downloaded(void)
{
    static narx_drive_t fresh;
    static const char head[] = "<?xml ";
    narx_frame_t frame = {0x0AAD5482u, 1, 0, 8, {0, 1}};
    int frames = 0;
    int in_order = 1;

    CHECK(narx_drive_poll_bulk_frame(&fresh, &frame) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_drive_init(&fresh, sizeof fresh, NULL) == NARX_OK);
    CHECK(narx_drive_poll_bulk_frame(&fresh, NULL) == NARX_ERROR_NULL);
    CHECK(narx_drive_handle_frame(&fresh, &frame) == NARX_OK);
    while (narx_drive_poll_bulk_frame(&fresh, &frame) == NARX_OK) {
        in_order &= frame.id == 0x1552A883u && frame.data[0] * 256 + frame.data[1] == frames * 3;
        if (frames == 0) {
            CHECK(memcmp(frame.data + 2, head, 6) == 0);
        }
        frames++;
    }
    CHECK(in_order);
    CHECK(frames > 5000 && frames < 65536 / 3);
}

/* The scope's memory is the caller's; what the drive puts there comes back over the bus. */
static void a_scope_records(void)
{
    static narx_drive_t fresh;
    static narx_scope_t memory;
    narx_samples_t samples = at_rest();
    narx_pwm_command_t command;
    narx_frame_t trigger = {0x0AAD5270u, 1, 0, 8, {0}};
    narx_frame_t download = {0x0AAD5470u, 1, 0, 8, {0}};
    narx_frame_t frame;
    int words = 0;
    int tick;

    const size_t small = narx_scope_size(64);

    CHECK(small < narx_scope_size(4096) && narx_scope_size(4096) <= sizeof memory);
    CHECK(narx_drive_attach_scope(&fresh, &memory, small) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_drive_init(&fresh, sizeof fresh, NULL) == NARX_OK);
    CHECK(narx_drive_attach_scope(&fresh, NULL, 64) == NARX_ERROR_NULL);
    CHECK(narx_drive_attach_scope(&fresh, &memory, narx_scope_size(0)) == NARX_ERROR_SIZE);
    CHECK(narx_drive_attach_scope(&fresh, (narx_scope_t *)((char *)&memory + 1), small) == NARX_ERROR_ALIGNMENT);
    CHECK(narx_drive_attach_scope(&fresh, &memory, small) == NARX_OK);
    CHECK(narx_drive_set_parameter(&fresh, NARX_PARAMETER_SCOPE_SAMPLES, 21) == NARX_OK);
    for (tick = 0; tick < 1000; tick++) {
        if (tick == 10 || tick == 20) {
            CHECK(narx_drive_handle_frame(&fresh, &trigger) == NARX_OK);
        } else if (tick == 500) {
            CHECK(parameter(&fresh, NARX_PARAMETER_SCOPE_STATE) == 3);
            CHECK(narx_drive_handle_frame(&fresh, &download) == NARX_OK);
        }
        samples.tick = (uint64_t)tick;
        CHECK(narx_drive_step(&fresh, &samples, &command) == NARX_OK);
        CHECK(narx_drive_run(&fresh, (uint64_t)tick) == NARX_OK);
        while (narx_drive_poll_frame(&fresh, &frame) == NARX_OK) {
        }
        while (narx_drive_poll_bulk_frame(&fresh, &frame) == NARX_OK) {
            CHECK(frame.id == 0x1552A870u && frame.data[0] * 256 + frame.data[1] == words);
            words += 3;
        }
    }
    /* Three signals: 21 samples fill 63 of the 64 words. */
    CHECK(words == 63);
}

static void storage_is_checked(void)
{
    static narx_drive_t fresh;
    static narx_drive_t moved;
    static narx_drive_t cast;
    narx_samples_t samples = at_rest();
    narx_pwm_command_t command;
    narx_frame_t frame = request_word(0);
    int32_t value = 7;
    narx_drive_t *askew = (narx_drive_t *)(void *)((unsigned char *)&cast + 1);

    CHECK(narx_drive_size() <= NARX_DRIVE_SIZE && narx_drive_size() <= sizeof fresh);
    CHECK(narx_drive_align() >= 4 && narx_drive_align() <= 8);

    CHECK(narx_drive_init(NULL, sizeof fresh, NULL) == NARX_ERROR_NULL);
    CHECK(narx_drive_init(askew, sizeof cast - 8, NULL) == NARX_ERROR_ALIGNMENT);
    CHECK(narx_drive_init(&fresh, narx_drive_size() - 1, NULL) == NARX_ERROR_SIZE);
    CHECK(narx_drive_init(&fresh, 0, NULL) == NARX_ERROR_SIZE);

    CHECK(narx_drive_step(&fresh, &samples, &command) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_drive_run(&fresh, 0) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_drive_handle_frame(&fresh, &frame) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_drive_poll_frame(&fresh, &frame) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_drive_set_parameter(&fresh, 0, 0) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_drive_get_parameter(&fresh, 0, &value) == NARX_ERROR_UNINITIALISED);
    CHECK(value == 7);

    CHECK(narx_drive_init(&fresh, narx_drive_size(), NULL) == NARX_OK);
    CHECK(narx_drive_run(&fresh, 0) == NARX_OK);
    memcpy(&moved, &fresh, sizeof fresh);
    CHECK(narx_drive_run(&moved, 0) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_drive_step(askew, &samples, &command) == NARX_ERROR_ALIGNMENT);
    CHECK(narx_drive_run(NULL, 0) == NARX_ERROR_NULL);
}

static void arguments_are_checked(void)
{
    static narx_drive_t fresh;
    narx_samples_t samples = at_rest();
    narx_pwm_command_t command;
    narx_frame_t frame = request_word(0);
    int32_t value;

    CHECK(narx_drive_init(&fresh, sizeof fresh, NULL) == NARX_OK);
    CHECK(narx_drive_step(&fresh, &samples, NULL) == NARX_ERROR_NULL);
    memset(&command, 0x55, sizeof command);
    CHECK(narx_drive_step(&fresh, NULL, &command) == NARX_ERROR_NULL);
    CHECK(command.step == NARX_STEP_COAST && command.duty == 0 && command.commutation_count == 0);
    samples.edge_count = NARX_EDGES_MAX + 1;
    memset(&command, 0x55, sizeof command);
    CHECK(narx_drive_step(&fresh, &samples, &command) == NARX_ERROR_SAMPLES);
    CHECK(command.step == NARX_STEP_COAST && command.duty == 0 && command.commutation_count == 0);
    samples.edge_count = NARX_EDGES_MAX;
    CHECK(narx_drive_step(&fresh, &samples, &command) == NARX_OK);
    samples.edges[3].source = 2;
    CHECK(narx_drive_step(&fresh, &samples, &command) == NARX_ERROR_SAMPLES);
    samples = at_rest();
    samples.sample_mode = 2;
    CHECK(narx_drive_step(&fresh, &samples, &command) == NARX_ERROR_SAMPLES);
    samples.sample_mode = NARX_SAMPLE_MODE_ON_TIME;
    samples.current_mode = 2;
    CHECK(narx_drive_step(&fresh, &samples, &command) == NARX_ERROR_SAMPLES);

    CHECK(narx_drive_handle_frame(&fresh, NULL) == NARX_ERROR_NULL);
    CHECK(narx_drive_poll_frame(&fresh, NULL) == NARX_ERROR_NULL);
    frame.length = 9;
    CHECK(narx_drive_handle_frame(&fresh, &frame) == NARX_ERROR_FRAME);
    frame.length = 8;
    frame.id = 0x20000000u;
    CHECK(narx_drive_handle_frame(&fresh, &frame) == NARX_ERROR_FRAME);
    frame.extended = 0;
    frame.id = 0x800u;
    CHECK(narx_drive_handle_frame(&fresh, &frame) == NARX_ERROR_FRAME);
    frame.id = 0x7FFu;
    frame.remote = 1;
    CHECK(narx_drive_handle_frame(&fresh, &frame) == NARX_OK);

    CHECK(narx_drive_get_parameter(&fresh, 60000, &value) == NARX_ERROR_UNKNOWN_PARAMETER);
    CHECK(narx_drive_get_parameter(&fresh, 0, NULL) == NARX_ERROR_NULL);
    CHECK(narx_drive_set_parameter(&fresh, 60000, 0) == NARX_ERROR_UNKNOWN_PARAMETER);
    CHECK(narx_drive_set_parameter(&fresh, NARX_PARAMETER_DRIVE_STATE, 0) == NARX_ERROR_READ_ONLY);
    CHECK(narx_drive_set_parameter(&fresh, NARX_PARAMETER_SENSORLESS_ENABLE, 2) == NARX_ERROR_OUT_OF_RANGE);
}

static void boards_are_checked(void)
{
    static narx_drive_t fresh;
    narx_samples_t samples = at_rest();
    narx_pwm_command_t command;
    narx_board_t board;

    CHECK(narx_board_default(NULL) == NARX_ERROR_NULL);
    CHECK(narx_board_default(&board) == NARX_OK);
    CHECK(board.tick_rate == 10000 && board.bus_current.zero == 2048);
    CHECK(narx_drive_init(&fresh, sizeof fresh, &board) == NARX_OK);
    board.bus_voltage.micro_per_code = 0;
    CHECK(narx_drive_init(&fresh, sizeof fresh, &board) == NARX_ERROR_BOARD);
    /* The drive that was there is still there. */
    CHECK(narx_drive_step(&fresh, &samples, &command) == NARX_OK);
    board.bus_voltage.micro_per_code = -1;
    CHECK(narx_drive_init(&fresh, sizeof fresh, &board) == NARX_ERROR_BOARD);
    narx_board_default(&board);
    board.tick_rate = 999;
    CHECK(narx_drive_init(&fresh, sizeof fresh, &board) == NARX_ERROR_BOARD);
    board.tick_rate = 20000;
    board.phase_voltage.zero = 4096;
    CHECK(narx_drive_init(&fresh, sizeof fresh, &board) == NARX_ERROR_BOARD);
    board.phase_voltage.zero = 4095;
    CHECK(narx_drive_init(&fresh, sizeof fresh, &board) == NARX_OK);
}

static void stored_parameters_are_taken(void)
{
    static narx_drive_t fresh;
    static const narx_identity_t identity = {20261122, 77, 3, 0x0102, 0};
    narx_stored_t stored[2] = {{NARX_PARAMETER_MOTOR_POLE_PAIRS, 7}, {NARX_PARAMETER_SLAVE_CAN_ADDRESS, 9}};
    narx_frame_t frame = {0x0AAD5000u, 1, 0, 8, {0}};

    CHECK(narx_drive_init_stored(&fresh, sizeof fresh, NULL, NULL, NULL, 2) == NARX_ERROR_NULL);
    CHECK(narx_drive_init_stored(&fresh, sizeof fresh, NULL, NULL, NULL, 0) == NARX_OK);
    CHECK(parameter(&fresh, NARX_PARAMETER_MOTOR_POLE_PAIRS) != 7);
    CHECK(narx_drive_init_stored(&fresh, sizeof fresh, NULL, &identity, stored, 2) == NARX_OK);
    CHECK(parameter(&fresh, NARX_PARAMETER_MOTOR_POLE_PAIRS) == 7);
    CHECK(parameter(&fresh, NARX_PARAMETER_BUILD_NUMBER) == 77 && parameter(&fresh, NARX_PARAMETER_HARDWARE_RELEASE) == 3);
    CHECK(parameter(&fresh, NARX_PARAMETER_REJECTED_PARAMETER) == 65535);
    /* The address counts from power-up on: the master of the factory's address is not received. */
    CHECK(narx_drive_handle_frame(&fresh, &frame) == NARX_OK);
    CHECK(narx_drive_poll_frame(&fresh, &frame) == NARX_NOTHING);
    /* Refused as a whole, and the drive that was there is still there. */
    stored[1].number = 60000;
    CHECK(narx_drive_init_stored(&fresh, sizeof fresh, NULL, NULL, stored, 2) == NARX_ERROR_UNKNOWN_PARAMETER);
    stored[1].number = NARX_PARAMETER_MOTOR_POLE_PAIRS;
    stored[1].value = 1000;
    CHECK(narx_drive_init_stored(&fresh, sizeof fresh, NULL, NULL, stored, 2) == NARX_ERROR_OUT_OF_RANGE);
    CHECK(parameter(&fresh, NARX_PARAMETER_SLAVE_CAN_ADDRESS) == 9);
}

static void recordings_are_checked(void)
{
    static const uint8_t other[] = "something else, long enough for a header";
    narx_outcome_t outcome;
    char text[NARX_OUTPUTS_TEXT_SIZE];
    char tiny[4] = {'x', 'x', 'x', 'x'};

    CHECK(narx_replay(NULL, 4, &outcome) == NARX_ERROR_NULL);
    CHECK(narx_replay(other, sizeof other, NULL) == NARX_ERROR_NULL);
    CHECK(narx_replay(other, SIZE_MAX, &outcome) == NARX_ERROR_SIZE);
    CHECK(narx_replay(other, sizeof other, &outcome) == NARX_ERROR_NOT_A_RECORDING);
    CHECK(narx_replay(other, 0, &outcome) == NARX_ERROR_TRUNCATED
          || narx_replay(other, 0, &outcome) == NARX_ERROR_NOT_A_RECORDING);
    CHECK(narx_replay((const uint8_t *)"narxrec\n", 8, &outcome) == NARX_ERROR_TRUNCATED);
    CHECK(narx_replay_transcript(NULL, 4, UINT64_MAX, &outcome) == NARX_ERROR_NULL);
    CHECK(narx_replay_transcript(other, sizeof other, UINT64_MAX, NULL) == NARX_ERROR_NULL);
    CHECK(narx_replay_transcript(other, sizeof other, 1, &outcome) == NARX_ERROR_NOT_A_RECORDING);
    CHECK(narx_replay_until(other, sizeof other, 1, &outcome, NULL, sizeof text) == NARX_ERROR_NULL);
    CHECK(narx_replay_until(other, sizeof other, 1, &outcome, NULL, 0) == NARX_ERROR_NOT_A_RECORDING);
    CHECK(narx_replay_until(other, sizeof other, 1, &outcome, text, sizeof text)
          == NARX_ERROR_NOT_A_RECORDING);
    CHECK(strstr(text, "not a narx recording") != NULL);
    CHECK(narx_replay_until(other, sizeof other, 1, &outcome, tiny, 3) == NARX_ERROR_NOT_A_RECORDING);
    CHECK(memcmp(tiny, "no", 3) == 0 && tiny[3] == 'x');
}

static void every_status_has_words(void)
{
    int32_t status;

    CHECK(strcmp(narx_version(), "") != 0);
    for (status = NARX_NOTHING; status >= NARX_ERROR_COMMISSIONING; status--) {
        CHECK(strcmp(narx_status_text(status), "unknown status") != 0);
    }
    CHECK(strcmp(narx_status_text(NARX_NOTHING + 1), "unknown status") == 0);
    CHECK(strcmp(narx_status_text(NARX_ERROR_COMMISSIONING - 1), "unknown status") == 0);
    CHECK(strcmp(narx_status_text(INT32_MIN), "unknown status") == 0);
}

int main(void)
{
    a_motor_starts_and_stops();
    a_description_is_downloaded();
    a_scope_records();
    storage_is_checked();
    arguments_are_checked();
    boards_are_checked();
    stored_parameters_are_taken();
    recordings_are_checked();
    every_status_has_words();
    return report_checks();
}
