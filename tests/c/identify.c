/* A drive measures the simulated motor, is commissioned from what it has measured, and turns it. Master and drive are in one program, as on
 * two boards with a bus between them. Prints a line of figures that are the same, bit for bit, wherever it runs. */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "check.h"
#include "narx.h"

enum { RPM = 2000 };

static narx_drive_t drive;
static narx_scope_t scope;
static narx_master_t master;
static narx_identification_t identification;
static uint64_t ticks;

/* A control tick of 100 us, and the frames of its time. */
static void step(void)
{
    narx_samples_t samples;
    narx_pwm_command_t command;
    narx_frame_t frame;

    bench_sample(&samples);
    (void)narx_drive_step(&drive, &samples, &command);
    bench_finish(&command);
    ticks++;
    while (narx_master_poll_frame(&master, ticks * 100u, &frame) == NARX_OK) {
        CHECK_QUIETLY(narx_drive_handle_frame(&drive, &frame) == NARX_OK);
    }
    if (ticks % 100 == 0) {
        narx_slow_inputs_t inputs;

        memset(&inputs, 0, sizeof inputs);
        inputs.ambient_temperature = 25 * NARX_Q16_ONE;
        inputs.accel_reference = narx_q16_from_milli(1800);
        (void)narx_drive_handle_inputs(&drive, &inputs);
    }
    (void)narx_drive_run(&drive, ticks);
    while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) {
        (void)narx_master_handle_frame(&master, &frame, ticks * 100u);
    }
    /* 4,000 of them a second: a bus of 500 kbit/s carries no more. */
    if (ticks % 3 == 0 && narx_drive_poll_bulk_frame(&drive, &frame) == NARX_OK) {
        (void)narx_master_handle_frame(&master, &frame, ticks * 100u);
    }
}

static void run(unsigned milliseconds)
{
    unsigned tick;

    for (tick = 0; tick < milliseconds * 10u; tick++) {
        step();
    }
}

/* Identifies the motor; returns the result, in at most a minute. */
static narx_status_t identify(const narx_identification_config_t *config, narx_identified_t *found, int abort_it)
{
    const uint64_t end = ticks + 600000u;
    narx_status_t result = NARX_NOTHING;
    uint8_t stage = 0;

    CHECK(narx_identification_init(&identification, sizeof identification, config) == NARX_OK);
    while (result == NARX_NOTHING && ticks < end) {
        step();
        result = narx_identification_step(&identification, &master, ticks * 100u, found);
        CHECK_QUIETLY(narx_identification_stage(&identification, &stage) == NARX_OK);
        if (abort_it && stage == NARX_IDENTIFICATION_STAGE_HOLDS) {
            CHECK_QUIETLY(narx_identification_abort(&identification, &master) == NARX_OK);
        }
    }
    CHECK(stage == NARX_IDENTIFICATION_STAGE_RESTORES);
    CHECK(narx_identification_step(&identification, &master, ticks * 100u, found) == NARX_NOTHING);
    return result;
}

/* Writes parameters, a request each. */
static void write_all(const narx_stored_t *parameters, size_t count)
{
    narx_answer_t answer;
    size_t index;

    for (index = 0; index < count; index++) {
        const narx_request_t request = {NARX_REQUEST_KIND_WRITE, parameters[index].number, parameters[index].value};
        unsigned milliseconds = 0;

        CHECK_QUIETLY(narx_master_request(&master, &request) == NARX_OK);
        do {
            run(1);
        } while (narx_master_poll_answer(&master, &answer) == NARX_NOTHING && ++milliseconds < 1000);
        CHECK_QUIETLY(answer.status == NARX_OK && answer.value == parameters[index].value);
    }
}

static int near(double value, double truth, double share)
{
    return fabs(value - truth) <= share * truth;
}

/* What is refused, and with which words. */
static void refusals(narx_identification_config_t config)
{
    narx_identified_t found;
    char text[200];

    /* Pole pairs of a rotor that is held are not counted. */
    config.hold = 1;
    CHECK(narx_identification_init(&identification, sizeof identification, &config) == NARX_ERROR_ARGUMENT);
    config.hold = 0;
    CHECK(narx_identification_init(&identification, sizeof identification, &config) == NARX_OK);
    CHECK(narx_identification_mark(&identification, 0) == NARX_ERROR_WRONG_STATE);
    config.pole_pairs = 4;
    config.current = 6.5;
    CHECK(narx_identification_init(&identification, sizeof identification, &config) == NARX_ERROR_ARGUMENT);
    config.current = 0.0;
    CHECK(narx_identification_init(&identification, 16, &config) == NARX_ERROR_SIZE);
    CHECK(narx_identification_init(&identification, sizeof identification, NULL) == NARX_ERROR_NULL);
    CHECK(narx_identification_size() <= sizeof identification);
    CHECK(identify(&config, &found, 1) == NARX_ERROR_ABORTED);
    CHECK(narx_identification_error_text(&identification, text, sizeof text) == NARX_OK);
    CHECK(strcmp(text, "the identification was aborted") == 0);
}

int main(void)
{
    narx_identification_config_t config;
    narx_identified_t found;
    narx_nameplate_t plate;
    narx_commissioned_t commissioned;
    narx_speed_loop_t loop;
    narx_job_failure_t failure;
    narx_drive_report_t report;
    narx_status_t end = NARX_NOTHING;
    char text[400];

    CHECK(bench_init(1) == 0);
    CHECK(narx_drive_init(&drive, sizeof drive, NULL) == NARX_OK);
    CHECK(narx_drive_attach_scope(&drive, &scope, sizeof scope) == NARX_OK);
    CHECK(narx_master_init(&master, sizeof master, NULL) == NARX_OK);
    CHECK(narx_master_stop(&master) == NARX_OK);
    run(1000);
    CHECK(narx_identification_config_default(&config) == NARX_OK);
    CHECK(config.pole_pairs == 0 && config.current == 0.0 && config.bridge == 0.04 && config.hold == 0 && config.halls == 0);
    refusals(config);
    run(500);

    /* bly172s-24v of the simulator's presets. */
    config.pole_pairs = 4;
    config.halls = 1;
    CHECK(identify(&config, &found, 0) == NARX_OK);
    CHECK(narx_identification_error_text(&identification, text, sizeof text) == NARX_NOTHING);
    CHECK(found.turned == 1 && found.pole_pairs == 4);
    CHECK(near(found.resistance.value, 0.768, 0.03));
    CHECK(near(found.inductance.value, 1.28e-3, 0.10));
    CHECK(near(found.torque_constant.value, 0.03443, 0.02));
    CHECK(near(found.inertia.value, 4.8e-6, 0.10));
    CHECK(near(found.temperature, 25.0, 0.05));
    CHECK(found.calibrated == 1 && found.hall_order <= 5 && found.hall_polarity <= 7);
    CHECK(found.hall_offset > -3.0 && found.hall_offset < 3.0);
    printf("%.3f ohm, %.3f mH, %.2f mN m/A, %.2f g cm2 after %lu ms\n", found.resistance.value, 1e3 * found.inductance.value,
        1e3 * found.torque_constant.value, 1e7 * found.inertia.value, (unsigned long)(ticks / 10u));

    memset(&plate, 0, sizeof plate);
    plate.mode = NARX_COMMISSIONING_MODE_SENSORLESS;
    CHECK(narx_nameplate_from_identified(&plate, &found) == NARX_OK);
    CHECK(plate.mode == NARX_COMMISSIONING_MODE_SENSORLESS && plate.supply == found.supply && plate.inertia == found.inertia.value);
    CHECK(narx_commission(&plate, &commissioned, text, sizeof text) == NARX_OK);
    CHECK(commissioned.speed_min < RPM && commissioned.speed_max > RPM);
    write_all(commissioned.parameters, NARX_COMMISSIONED);
    CHECK(narx_speed_loop(&plate, commissioned.speed_min, 0.0, &loop, NULL, 0) == NARX_OK);
    CHECK(loop.bandwidth > 1.0 && loop.phase_margin > 59.9);
    write_all(loop.parameters, NARX_SPEED_LOOP_PARAMETERS);
    CHECK(narx_master_begin(&master, NARX_JOB_KIND_START, RPM) == NARX_OK);
    while (end == NARX_NOTHING) {
        run(1);
        end = narx_master_poll_job(&master, &failure);
    }
    CHECK(end == NARX_OK);
    run(2000);
    CHECK(narx_master_report(&master, ticks * 100u, &report) == NARX_OK && report.state == NARX_STATE_SENSORLESS_CLOSED_LOOP);
    CHECK(near(bench_rpm(), RPM, 0.005));

    /* What cannot be commissioned, and why. */
    found.turned = 0;
    CHECK(narx_nameplate_from_identified(&plate, &found) == NARX_ERROR_ARGUMENT);
    CHECK(narx_speed_loop(&plate, commissioned.speed_min, 2.0 * loop.bandwidth, &loop, text, sizeof text) == NARX_ERROR_COMMISSIONING);
    CHECK(strstr(text, "must be greater than 0, and at most") != NULL);
    plate.supply = 12.0;
    CHECK(narx_commission(&plate, &commissioned, text, sizeof text) == NARX_ERROR_COMMISSIONING);
    CHECK(strcmp(text, "supply voltage 12 V is outside 18 to 60 V") == 0);
    plate.mode = 3;
    CHECK(narx_commission(&plate, &commissioned, text, sizeof text) == NARX_ERROR_ARGUMENT);
    plate.inertia = 0.0;
    CHECK(narx_speed_loop(&plate, 500.0, 0.0, &loop, text, sizeof text) == NARX_ERROR_COMMISSIONING);
    CHECK(strcmp(text, "motor inertia 0 must be greater than 0") == 0);
    return report_checks();
}
