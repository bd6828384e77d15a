/* Both protocols from both ends: a drive and its master, a TX-Driver and its master, on a bus of two queues; every message packed
 * and unpacked; and every misuse an error code. Prints `N passed, N failed`. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "narx.h"

static narx_drive_t drive;
static narx_master_t master;
static uint64_t tick;

/* A board at rest: 24 V on the bus (19.531 mV a code), no current, rotor in sector 0. */
static narx_samples_t at_rest(void)
{
    narx_samples_t samples;

    memset(&samples, 0, sizeof samples);
    samples.bus_voltage = 1229;
    samples.bus_current = 2048;
    samples.hall = 1;
    samples.tick = tick;
    return samples;
}

/* Control ticks of 100 us with drive and master on one bus. */
static void run(int ticks)
{
    narx_pwm_command_t command;
    narx_frame_t frame;

    while (ticks-- > 0) {
        const narx_samples_t samples = at_rest();
        const uint64_t now = tick * 100u;

        CHECK_QUIETLY(narx_drive_step(&drive, &samples, &command) == NARX_OK);
        while (narx_master_poll_frame(&master, now, &frame) == NARX_OK) {
            CHECK_QUIETLY(narx_drive_handle_frame(&drive, &frame) == NARX_OK);
        }
        CHECK_QUIETLY(narx_drive_run(&drive, tick) == NARX_OK);
        while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) {
            CHECK_QUIETLY(narx_master_handle_frame(&master, &frame, now) == NARX_OK);
        }
        if (narx_drive_poll_bulk_frame(&drive, &frame) == NARX_OK) {
            CHECK_QUIETLY(narx_master_handle_frame(&master, &frame, now) == NARX_OK);
        }
        tick++;
    }
}

static narx_answer_t ask(uint8_t kind, uint16_t number, int32_t value)
{
    narx_request_t request = {0, 0, 0};
    narx_answer_t answer;

    request.kind = kind;
    request.number = number;
    request.value = value;
    memset(&answer, 0x55, sizeof answer);
    CHECK(narx_master_request(&master, &request) == NARX_OK);
    CHECK(narx_master_poll_answer(&master, &answer) == NARX_NOTHING);
    run(200);
    CHECK(narx_master_poll_answer(&master, &answer) == NARX_OK);
    CHECK(answer.request.kind == kind && answer.request.number == number && answer.request.value == value);
    return answer;
}

static void a_master_receives_and_asks(void)
{
    narx_master_config_t config;
    narx_drive_report_t report;
    narx_message_t message;
    narx_answer_t answer;
    int32_t value = 0;
    uint64_t at = 0;

    CHECK(narx_master_config_default(&config) == NARX_OK);
    CHECK(config.drive == 170 && config.master == 85 && config.setpoint_period == 50000);
    CHECK(narx_master_init(&master, sizeof master, &config) == NARX_OK);
    CHECK(narx_drive_init(&drive, sizeof drive, NULL) == NARX_OK);
    CHECK(narx_master_report(&master, 0, &report) == NARX_OK);
    CHECK(!report.connected && report.state == 255 && report.motor_mode == 255);
    CHECK(narx_master_measurement(&master, NARX_MESSAGE_MEASUREMENT_2, &message, &at) == NARX_NOTHING);
    CHECK(narx_master_parameter(&master, NARX_PARAMETER_MOTOR_POLE_PAIRS, &value, NULL) == NARX_NOTHING);

    CHECK(narx_master_stop(&master) == NARX_OK);
    run(10000);
    CHECK(narx_master_report(&master, tick * 100u, &report) == NARX_OK);
    CHECK(report.connected && report.state == NARX_STATE_STANDBY && report.motor_mode == NARX_MOTOR_MODE_STANDBY);
    CHECK(report.control_mode == NARX_CONTROL_MODE_OFF);
    CHECK(narx_master_measurement(&master, NARX_MESSAGE_MEASUREMENT_2, &message, &at) == NARX_OK);
    /* 24.00 V in 0.01 V. */
    CHECK(message.kind == NARX_MESSAGE_MEASUREMENT_2 && abs(message.fields.measurement_2.hv_voltage - 2400) < 5);
    CHECK(at > 0 && at < tick * 100u);

    answer = ask(NARX_REQUEST_KIND_WRITE, NARX_PARAMETER_MOTOR_POLE_PAIRS, 7);
    CHECK(answer.status == NARX_OK && answer.value == 7);
    answer = ask(NARX_REQUEST_KIND_READ, NARX_PARAMETER_MOTOR_POLE_PAIRS, 0);
    CHECK(answer.status == NARX_OK && answer.value == 7);
    CHECK(narx_master_parameter(&master, NARX_PARAMETER_MOTOR_POLE_PAIRS, &value, &at) == NARX_OK && value == 7);
    answer = ask(NARX_REQUEST_KIND_WRITE, NARX_PARAMETER_MOTOR_POLE_PAIRS, 1000);
    CHECK(answer.status == NARX_ERROR_OUT_OF_RANGE && answer.value == 7);
    CHECK(ask(NARX_REQUEST_KIND_READ, 60000, 0).status == NARX_ERROR_UNKNOWN_PARAMETER);
    /* There is no parameter store here. */
    CHECK(ask(NARX_REQUEST_KIND_RUN, NARX_PARAMETER_STORE, 0).status == NARX_ERROR_STORAGE);
    CHECK(ask(NARX_REQUEST_KIND_DEVICE_INFO, 0, 0).status == NARX_OK);
    CHECK(ask(NARX_REQUEST_KIND_DIGITAL_OUTPUTS, 0, 3).status == NARX_OK);
    CHECK(ask(NARX_REQUEST_KIND_DISABLE_HALL_SUPPLY, 0, 1).status == NARX_OK);
    CHECK(narx_master_next_poll(&master, tick * 100u, &at) == NARX_OK && at >= tick * 100u);
}

static void the_board_is_told_and_tells(void)
{
    static const narx_slow_inputs_t warm = {.ambient_temperature = 40 * NARX_Q16_ONE, .rail_6v = 6 * NARX_Q16_ONE};
    narx_bus_state_t state = {1, 130, 4};
    narx_outputs_t outputs;
    narx_message_t message;
    narx_frame_t frame;

    CHECK(narx_drive_outputs(&drive, &outputs) == NARX_OK);
    CHECK(outputs.dsio1_enable && outputs.dsio1_level && !outputs.dsio2_enable && !outputs.hall_supply);
    CHECK(narx_drive_handle_inputs(&drive, &warm) == NARX_OK);
    run(1000);
    CHECK(narx_master_measurement(&master, NARX_MESSAGE_MEASUREMENT_3, &message, NULL) == NARX_OK);
    CHECK(message.fields.measurement_3.ambient_temperature == 400);

    CHECK(narx_drive_handle_bus_state(&drive, &state) == NARX_OK);
    CHECK(ask(NARX_REQUEST_KIND_READ, NARX_PARAMETER_TRANSMIT_ERRORS, 0).value == 130);
    state.error = 3;
    CHECK(narx_drive_handle_bus_state(&drive, &state) == NARX_ERROR_BUS_STATE);
    state.error = 2;
    CHECK(narx_drive_handle_bus_state(&drive, &state) == NARX_OK);
    CHECK(narx_drive_run(&drive, tick + 1000) == NARX_OK);
    CHECK(narx_drive_poll_frame(&drive, &frame) == NARX_NOTHING);
    state.error = 0;
    CHECK(narx_drive_handle_bus_state(&drive, &state) == NARX_OK);

    CHECK(narx_drive_take_reboot(&drive) == NARX_NOTHING);
    CHECK(ask(NARX_REQUEST_KIND_REBOOT, 0, 0).status == NARX_OK);
    CHECK(narx_drive_take_reboot(&drive) == NARX_OK);
    CHECK(narx_drive_take_reboot(&drive) == NARX_NOTHING);
}

static void a_master_downloads(void)
{
    static char text[8];
    narx_chunk_t chunk;
    uint32_t words = 0;
    uint32_t most = 0;
    int wait;

    CHECK(narx_drive_init(&drive, sizeof drive, NULL) == NARX_OK);
    CHECK(narx_master_init(&master, sizeof master, NULL) == NARX_OK);
    CHECK(narx_master_download(&master, 3, 0, 0) == NARX_ERROR_REQUEST);
    CHECK(narx_master_download(&master, NARX_DOWNLOAD_KIND_DESCRIPTION, 0, 0) == NARX_OK);
    CHECK(narx_master_download(&master, NARX_DOWNLOAD_KIND_DESCRIPTION, 0, 0) == NARX_ERROR_FULL);
    CHECK(narx_master_poll_download(&master, &words) == NARX_NOTHING);
    for (wait = 0; wait < 40000 && narx_master_poll_download(&master, &words) == NARX_NOTHING; wait++) {
        run(1);
        while (narx_master_poll_chunk(&master, &chunk) == NARX_OK) {
            int i;

            for (i = 0; i < chunk.length; i++) {
                const uint32_t at = 2 * (chunk.offset + (uint32_t)i);

                if (at < 6) {
                    text[at] = (char)(chunk.words[i] >> 8);
                    text[at + 1] = (char)(chunk.words[i] & 0xFF);
                }
                most = chunk.offset + (uint32_t)i + 1 > most ? chunk.offset + (uint32_t)i + 1 : most;
            }
        }
    }
    CHECK(words > 10000 && words == most);
    CHECK(strcmp(text, "<?xml ") == 0);
    CHECK(narx_master_download(&master, NARX_DOWNLOAD_KIND_SCOPE, 0, 100) == NARX_OK);
    CHECK(narx_master_abort_download(&master) == NARX_OK);
    run(200);
    CHECK(narx_master_poll_download(&master, &words) == NARX_ERROR_ABORTED);
}

/* A drive with hall sensors says its limits; another set-point is refused. */
static void set_points_are_checked(void)
{
    static const uint16_t said[5][2] = {{78, 4}, {83, 1}, {104, 600}, {103, 2191}, {0, 0}};
    static narx_master_t asking;
    narx_speed_limits_t limits;
    narx_frame_t frame = {0};
    int i;

    CHECK(narx_master_init(&asking, sizeof asking, NULL) == NARX_OK);
    CHECK(narx_master_speed_limits(&asking, &limits) == NARX_NOTHING);
    CHECK(narx_master_start(&asking, 3120) == NARX_OK);
    frame.id = 0x1552A86E;
    frame.extended = 1;
    frame.length = 8;
    for (i = 0; said[i][0] != 0; i++) {
        frame.data[1] = (uint8_t)said[i][0];
        frame.data[4] = (uint8_t)(said[i][1] >> 8);
        frame.data[5] = (uint8_t)said[i][1];
        CHECK(narx_master_handle_frame(&asking, &frame, 1000) == NARX_OK);
    }
    CHECK(narx_master_speed_limits(&asking, NULL) == NARX_ERROR_NULL);
    CHECK(narx_master_speed_limits(&asking, &limits) == NARX_OK);
    CHECK(limits.min == 600 && limits.min_parameter == 104);
    CHECK(limits.max == 2191 && limits.max_parameter == 103);
    CHECK(narx_master_start(&asking, 3120) == NARX_ERROR_SPEED);
    CHECK(narx_master_start(&asking, -599) == NARX_ERROR_SPEED);
    CHECK(narx_master_start(&asking, -2191) == NARX_OK);
    CHECK(narx_master_set_speed(&asking, 2192) == NARX_ERROR_SPEED);
    CHECK(narx_master_set_speed(&asking, 600) == NARX_OK);
}

static void masters_are_checked(void)
{
    static narx_master_t none;
    static narx_master_t copy;
    narx_master_config_t config;
    narx_frame_t frame;
    narx_request_t request = {200, 0, 0};
    int i;

    CHECK(narx_master_size() <= sizeof none);
    CHECK(narx_master_config_default(NULL) == NARX_ERROR_NULL);
    CHECK(narx_master_init(NULL, sizeof none, NULL) == NARX_ERROR_NULL);
    CHECK(narx_master_init((narx_master_t *)((char *)&copy + 1), sizeof none, NULL) == NARX_ERROR_ALIGNMENT);
    CHECK(narx_master_init(&none, narx_master_size() - 1, NULL) == NARX_ERROR_SIZE);
    CHECK(narx_master_stop(&none) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_master_poll_frame(&none, 0, &frame) == NARX_ERROR_UNINITIALISED);
    /* A drive is no master. */
    CHECK(narx_master_start((narx_master_t *)(void *)&drive, 1) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_master_init(&none, sizeof none, NULL) == NARX_OK);
    /* It holds no pointers: a copy is another one. */
    copy = none;
    CHECK(narx_master_start(&copy, -65536) == NARX_ERROR_SPEED);
    CHECK(narx_master_start(&copy, -1200) == NARX_OK);
    CHECK(narx_master_poll_frame(&copy, 0, &frame) == NARX_OK);
    CHECK(narx_master_poll_frame(&none, 0, NULL) == NARX_ERROR_NULL);
    CHECK(narx_master_request(&none, &request) == NARX_ERROR_REQUEST);
    request.kind = NARX_REQUEST_KIND_RUN;
    request.number = NARX_PARAMETER_MOTOR_POLE_PAIRS;
    CHECK(narx_master_request(&none, &request) == NARX_ERROR_REQUEST);
    request.kind = NARX_REQUEST_KIND_DIGITAL_OUTPUTS;
    request.value = 16;
    CHECK(narx_master_request(&none, &request) == NARX_ERROR_REQUEST);
    request.kind = NARX_REQUEST_KIND_READ;
    for (i = 0; i < 8; i++) {
        CHECK(narx_master_request(&none, &request) == NARX_OK);
    }
    CHECK(narx_master_request(&none, &request) == NARX_ERROR_FULL);
    CHECK(narx_master_config_default(&config) == NARX_OK);
    config.silent = 1;
    CHECK(narx_master_init(&none, sizeof none, &config) == NARX_OK);
    CHECK(narx_master_request(&none, &request) == NARX_ERROR_SILENT);
    CHECK(narx_master_poll_frame(&none, 1000000, &frame) == NARX_NOTHING);
}

static void every_message_is_packed_and_unpacked(void)
{
    narx_message_t message;
    narx_message_t read;
    narx_frame_t frame;
    unsigned kinds = 0;
    unsigned kind;

    for (kind = 0; kind < 2048; kind++) {
        memset(&message, 0, sizeof message);
        message.kind = (uint16_t)kind;
        message.drive = 3;
        message.master = 200;
        message.fields.raw[0] = kind == NARX_MESSAGE_REBOOT;
        if (narx_message_encode(&message, &frame) == NARX_OK) {
            kinds++;
            CHECK((frame.id & 0x7FF) == kind && frame.extended && frame.length == 8);
            CHECK(narx_message_decode(&frame, &read) == NARX_OK);
            CHECK(memcmp(&read, &message, sizeof read) == 0);
        } else {
            CHECK_QUIETLY(narx_message_encode(&message, &frame) == NARX_ERROR_NOT_A_MESSAGE);
        }
    }
    CHECK(kinds == 33);

    /* Figure 14: master 85 asks drive 170 for Reverse. */
    memset(&message, 0, sizeof message);
    message.kind = NARX_MESSAGE_REQUEST_WORD;
    message.drive = 170;
    message.master = 85;
    message.fields.request_word.motor_mode = NARX_MOTOR_MODE_REVERSE;
    CHECK(narx_message_encode(&message, &frame) == NARX_OK);
    CHECK(frame.id == 0x0AAD5202u && frame.data[3] == 2);
    message.fields.request_word.motor_mode = 4;
    CHECK(narx_message_encode(&message, &frame) == NARX_ERROR_FIELD);
    frame.data[3] = 4;
    CHECK(narx_message_decode(&frame, &read) == NARX_ERROR_FIELD);

    message.kind = NARX_MESSAGE_PARAMETER_SET;
    message.fields.parameter_set.number = NARX_PARAMETER_SPEED_RATE;
    message.fields.parameter_set.value = -2;
    CHECK(narx_message_encode(&message, &frame) == NARX_OK);
    CHECK(frame.data[1] == 99 && frame.data[2] == 0xFF && frame.data[5] == 0xFE && frame.data[7] == 0);
    message.fields.parameter_set.number = 65536;
    CHECK(narx_message_encode(&message, &frame) == NARX_ERROR_FIELD);
    frame.length = 7;
    CHECK(narx_message_decode(&frame, &read) == NARX_ERROR_NOT_A_MESSAGE);
    frame.length = 9;
    CHECK(narx_message_decode(&frame, &read) == NARX_ERROR_FRAME);
    frame.length = 8;
    frame.extended = 0;
    frame.id = 0x181;
    CHECK(narx_message_decode(&frame, &read) == NARX_ERROR_NOT_A_MESSAGE);
    CHECK(narx_message_decode(NULL, &read) == NARX_ERROR_NULL);
    CHECK(narx_message_decode(&frame, NULL) == NARX_ERROR_NULL);
    CHECK(narx_message_encode(&message, NULL) == NARX_ERROR_NULL);
}

static narx_tx_driver_t node;
static narx_tx_master_t other;
static const narx_tx_variant_t variant = {2, 0x0102, 10000, {-(1 << 27), -(1 << 27)}, {1 << 27, 1 << 27}};
static const narx_tx_layout_t dual = {2, 0};

/* Samples of 100 us with node and master on one bus. Answers how many frames the node has sent. */
static int positions(uint64_t *now, int samples)
{
    narx_frame_t frame;
    int frames = 0;

    for (; samples > 0; samples--, *now += 100) {
        CHECK_QUIETLY(narx_tx_driver_handle_sample(&node, 1 << 20, -(1 << 20), 5) == NARX_OK);
        while (narx_tx_master_poll_frame(&other, *now, &frame) == NARX_OK) {
            CHECK_QUIETLY(narx_tx_driver_handle_frame(&node, &frame, *now) == NARX_OK);
        }
        CHECK_QUIETLY(narx_tx_driver_poll(&node, *now) == NARX_OK);
        while (narx_tx_driver_poll_frame(&node, &frame) == NARX_OK) {
            frames++;
            CHECK_QUIETLY(narx_tx_master_handle_frame(&other, &frame, *now) == NARX_OK);
        }
    }
    return frames;
}

static void a_tx_driver_measures(void)
{
    uint32_t values[NARX_TX_VALUES];
    narx_tx_driver_report_t told;
    narx_tx_node_report_t report;
    narx_tx_answer_t answer;
    uint64_t now = 0;
    uint64_t at = 0;

    CHECK(narx_tx_driver_init(&node, sizeof node, &variant, NULL) == NARX_OK);
    CHECK(narx_tx_master_init(&other, sizeof other, 1, &dual) == NARX_OK);
    CHECK(positions(&now, 10) == 1);
    CHECK(narx_tx_master_report(&other, now, &report) == NARX_OK);
    CHECK(report.present && report.boots == 1 && report.at == UINT64_MAX);
    CHECK(narx_tx_driver_report(&node, &told) == NARX_OK);
    CHECK(told.bits_per_second == 500000 && told.node == 1 && told.state == 127 && told.layout.channels == 2);

    /* PDO1 every 2 ms. */
    CHECK(narx_tx_master_write(&other, NARX_TX_ENTRY_UPDATE_TIME, 2) == NARX_OK);
    CHECK(narx_tx_master_read(&other, NARX_TX_ENTRY_FIRMWARE_VERSION) == NARX_OK);
    CHECK(narx_tx_master_write(&other, NARX_TX_ENTRY_BITRATE_INDEX, 9) == NARX_OK);
    CHECK(narx_tx_master_read(&other, 14) == NARX_ERROR_UNKNOWN_ENTRY);
    positions(&now, 100);
    CHECK(narx_tx_master_poll_answer(&other, &answer) == NARX_OK);
    CHECK(answer.status == NARX_OK && answer.value == 2 && answer.written && answer.entry == NARX_TX_ENTRY_UPDATE_TIME);
    CHECK(narx_tx_master_poll_answer(&other, &answer) == NARX_OK);
    CHECK(answer.status == NARX_OK && answer.value == 0x0102 && !answer.written);
    CHECK(narx_tx_master_poll_answer(&other, &answer) == NARX_OK);
    CHECK(answer.status == NARX_ERROR_ENTRY && answer.value == 0x06090030u);
    CHECK(narx_tx_master_poll_answer(&other, &answer) == NARX_NOTHING);

    CHECK(narx_tx_master_command(&other, 1, 0) == NARX_OK);
    CHECK(narx_tx_master_command(&other, 3, 0) == NARX_ERROR_FIELD);
    CHECK(positions(&now, 1000) >= 49);
    CHECK(narx_tx_master_report(&other, now, &report) == NARX_OK);
    CHECK(report.positions[0] == 1 << 20 && report.positions[1] == -(1 << 20) && report.at < now);
    CHECK(narx_tx_master_sync(&other) == NARX_OK);
    CHECK(narx_tx_master_ask_positions(&other) == NARX_OK);
    CHECK(positions(&now, 10) >= 2);
    CHECK(narx_tx_driver_next_poll(&node, &at) == NARX_OK && at > now - 3000);

    /* What was written is to be stored, and is there after a restart. */
    CHECK(narx_tx_driver_poll_store(&node, values) == NARX_OK);
    CHECK(values[NARX_TX_ENTRY_UPDATE_TIME] == 2);
    CHECK(narx_tx_driver_poll_store(&node, values) == NARX_NOTHING);
    CHECK(narx_tx_driver_handle_store(&node, 1) == NARX_OK);
    CHECK(narx_tx_driver_take_reset(&node) == NARX_NOTHING);
    CHECK(narx_tx_master_command(&other, 129, 1) == NARX_OK);
    positions(&now, 10);
    CHECK(narx_tx_driver_take_reset(&node) == NARX_OK);
    CHECK(narx_tx_driver_init(&node, sizeof node, &variant, values) == NARX_OK);
    CHECK(narx_tx_master_read(&other, NARX_TX_ENTRY_UPDATE_TIME) == NARX_OK);
    positions(&now, 100);
    CHECK(narx_tx_master_poll_answer(&other, &answer) == NARX_OK && answer.value == 2);
    values[NARX_TX_ENTRY_NODE_ID] = 0;
    CHECK(narx_tx_driver_init(&node, sizeof node, &variant, values) == NARX_ERROR_OUT_OF_RANGE);
}

static void tx_drivers_are_checked(void)
{
    static narx_tx_driver_t none;
    narx_tx_variant_t wrong = variant;
    narx_tx_layout_t layout = {3, 0};

    CHECK(narx_tx_driver_size() <= sizeof none && narx_tx_master_size() <= sizeof other);
    CHECK(narx_tx_driver_poll(&none, 0) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_tx_driver_poll(NULL, 0) == NARX_ERROR_NULL);
    CHECK(narx_tx_driver_init(&none, sizeof none, NULL, NULL) == NARX_ERROR_NULL);
    CHECK(narx_tx_driver_init(&none, 8, &variant, NULL) == NARX_ERROR_SIZE);
    wrong.channels = 3;
    CHECK(narx_tx_driver_init(&none, sizeof none, &wrong, NULL) == NARX_ERROR_VARIANT);
    wrong = variant;
    wrong.range_end[1] = wrong.range_start[1];
    CHECK(narx_tx_driver_init(&none, sizeof none, &wrong, NULL) == NARX_ERROR_VARIANT);
    wrong.channels = 1;
    CHECK(narx_tx_driver_init(&none, sizeof none, &wrong, NULL) == NARX_OK);
    CHECK(narx_tx_master_init(&other, sizeof other, 0, &dual) == NARX_ERROR_NODE);
    CHECK(narx_tx_master_init(&other, sizeof other, 128, &dual) == NARX_ERROR_NODE);
    CHECK(narx_tx_master_init(&other, sizeof other, 1, &layout) == NARX_ERROR_VARIANT);
}

static int same(const narx_tx_message_t *a, const narx_tx_message_t *b)
{
    return a->kind == b->kind && a->node == b->node && a->command == b->command && a->subindex == b->subindex
        && a->index == b->index && a->encoder == b->encoder && a->size == b->size && a->from_node == b->from_node
        && a->value == b->value && a->positions[0] == b->positions[0] && a->positions[1] == b->positions[1];
}

static void every_tx_message_is_packed_and_unpacked(void)
{
    static const narx_tx_message_t messages[] = {
        {.kind = NARX_TX_KIND_NMT, .node = 0, .command = 1},
        {.kind = NARX_TX_KIND_NMT, .node = 5, .command = 129},
        {.kind = NARX_TX_KIND_SYNC},
        {.kind = NARX_TX_KIND_REQUEST_PDO, .node = 127, .size = 8},
        {.kind = NARX_TX_KIND_READ, .node = 1, .index = 0x2006, .subindex = 2},
        {.kind = NARX_TX_KIND_WRITE, .node = 1, .index = 0x2003, .value = 65535, .size = 2},
        {.kind = NARX_TX_KIND_WRITE, .node = 1, .index = 0x2003, .value = 1},
        {.kind = NARX_TX_KIND_ABORT, .node = 1, .index = 0x2003, .value = 0x08000000u},
        {.kind = NARX_TX_KIND_HEARTBEAT, .node = 2, .command = 5},
        {.kind = NARX_TX_KIND_ERROR, .node = 2, .value = 0x8120},
        {.kind = NARX_TX_KIND_PDO, .node = 2, .command = 3, .positions = {INT32_MIN, INT32_MAX}},
        {.kind = NARX_TX_KIND_WRITTEN, .node = 2, .index = 0x2003},
        {.kind = NARX_TX_KIND_VALUE, .node = 2, .index = 0x2007, .subindex = 1, .value = 1u << 29, .size = 4},
        {.kind = NARX_TX_KIND_ABORT, .node = 2, .index = 0x2003, .value = 0x06010002u, .from_node = 1},
    };
    narx_tx_message_t read;
    narx_tx_message_t wrong;
    narx_frame_t frame;
    size_t i;

    for (i = 0; i < sizeof messages / sizeof messages[0]; i++) {
        CHECK(narx_tx_message_encode(&messages[i], &dual, &frame) == NARX_OK);
        CHECK(narx_tx_message_decode(&frame, &dual, &read) == NARX_OK);
        CHECK(same(&read, &messages[i]));
    }
    /* The last: an abort of node 2. */
    CHECK(frame.id == 0x582 && frame.data[0] == 0x80 && frame.data[1] == 0x03 && frame.data[2] == 0x20);
    wrong = messages[0];
    wrong.command = 3;
    CHECK(narx_tx_message_encode(&wrong, &dual, &frame) == NARX_ERROR_FIELD);
    wrong.kind = 11;
    wrong.node = 1;
    CHECK(narx_tx_message_encode(&wrong, &dual, &frame) == NARX_ERROR_NOT_A_MESSAGE);
    wrong = messages[8];
    wrong.node = 0;
    CHECK(narx_tx_message_encode(&wrong, &dual, &frame) == NARX_ERROR_NODE);
    frame.id = 0x202;
    frame.extended = 0;
    frame.remote = 0;
    frame.length = 8;
    CHECK(narx_tx_message_decode(&frame, &dual, &read) == NARX_ERROR_NOT_A_MESSAGE);
    /* Positions of another layout. */
    frame.id = 0x182;
    frame.length = 4;
    CHECK(narx_tx_message_decode(&frame, &dual, &read) == NARX_ERROR_NOT_A_MESSAGE);
    CHECK(narx_tx_message_decode(&frame, NULL, &read) == NARX_ERROR_NULL);
    CHECK(narx_tx_message_encode(NULL, &dual, &frame) == NARX_ERROR_NULL);
}

static void formats_are_converted(void)
{
    CHECK(narx_q16_from_milli(1500) == NARX_Q16_ONE * 3 / 2 && narx_q16_from_milli(INT32_MIN) == INT32_MIN);
    CHECK(narx_milli_from_q16(NARX_Q16_ONE / 2) == 500 && narx_milli_from_q16(INT32_MIN) == -32768000);
    CHECK(narx_q16_add(INT32_MAX, 1) == INT32_MAX && narx_q16_subtract(INT32_MIN, 1) == INT32_MIN);
    CHECK(narx_q16_multiply(3 * NARX_Q16_ONE / 2, -2 * NARX_Q16_ONE) == -3 * NARX_Q16_ONE);
    CHECK(narx_q16_multiply(INT32_MAX, INT32_MAX) == INT32_MAX && narx_q16_multiply(INT32_MIN, INT32_MAX) == INT32_MIN);
    CHECK(narx_q16_divide(NARX_Q16_ONE, 4 * NARX_Q16_ONE) == NARX_Q16_ONE / 4);
    CHECK(narx_q16_divide(5, 0) == INT32_MAX && narx_q16_divide(-5, 0) == INT32_MIN && narx_q16_divide(0, 0) == 0);
    CHECK(narx_q16_divide(INT32_MIN, -1) == INT32_MAX);
    CHECK(narx_iq24_from_q16(NARX_Q16_ONE) == NARX_IQ24_ONE && narx_iq24_from_q16(128 * NARX_Q16_ONE) == INT32_MAX);
    CHECK(narx_iq24_from_q16(-129 * NARX_Q16_ONE) == INT32_MIN && narx_q16_from_iq24(-NARX_IQ24_ONE) == -NARX_Q16_ONE);
    CHECK(narx_q16_from_iq24(-1) == -1);
    CHECK(narx_q15_from_q16(NARX_Q16_ONE) == 32767 && narx_q15_from_q16(-NARX_Q16_ONE) == -32768);
    CHECK(narx_q16_from_q15(-32768) == -NARX_Q16_ONE && narx_q16_from_q15(1) == 2);
    CHECK(narx_q12_from_q16(NARX_Q16_ONE) == NARX_Q12_ONE && narx_q12_from_q16(8 * NARX_Q16_ONE) == 32767);
    CHECK(narx_q16_from_q12(NARX_Q12_ONE) == NARX_Q16_ONE);
}

int main(void)
{
    a_master_receives_and_asks();
    the_board_is_told_and_tells();
    a_master_downloads();
    masters_are_checked();
    set_points_are_checked();
    every_message_is_packed_and_unpacked();
    a_tx_driver_measures();
    tx_drivers_are_checked();
    every_tx_message_is_packed_and_unpacked();
    formats_are_converted();
    return report_checks();
}
