/* The whole drive of ffi/examples/drive.c on a simulated board with a simulated motor, commanded over CAN by a master in the same program.
 * On a microcontroller the control interrupt is a real one (PendSV), and strikes in the main loop. Prints a line of figures that are the
 * same, bit for bit, wherever it runs; exit code 0 if the motor runs as it was asked to.
 *
 *     spin [--sensorless]
 */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "board.h"
#include "check.h"
#include "drive.h"
#include "narx.h"

enum { RPM = 2000, QUEUE = 16, STORED = 64 };

static narx_master_t master;
static uint64_t ticks;

/* FNV-1a of everything that was applied. */
static uint32_t digest = 2166136261u;

static void note(uint32_t value)
{
    digest = (digest ^ value) * 16777619u;
}

/* The board. */

static narx_frame_t to_drive[QUEUE];
static unsigned received;
static unsigned waiting;

void board_sample(narx_samples_t *samples)
{
    bench_sample(samples);
}

void board_apply(const narx_pwm_command_t *command)
{
    note(command->duty);
    note(command->sample_at);
    note(command->step);
    note(command->commutation_count);
    bench_finish(command);
    ticks++;
}

int board_receive(narx_frame_t *frame)
{
    if (received == waiting) {
        received = 0;
        waiting = 0;
        return 0;
    }
    *frame = to_drive[received++];
    return 1;
}

void board_send(const narx_frame_t *frame)
{
    CHECK_QUIETLY(narx_master_handle_frame(&master, frame, ticks * 100u) == NARX_OK);
}

int board_sends_at_once(void)
{
    return 1;
}

void board_slow_inputs(narx_slow_inputs_t *inputs)
{
    memset(inputs, 0, sizeof *inputs);
    inputs->ambient_temperature = 25 * NARX_Q16_ONE;
    inputs->accel_reference = narx_q16_from_milli(1800);
}

uint64_t board_ticks(void)
{
    return ticks;
}

void board_reset(void)
{
    CHECK(!"nobody has asked for it");
}

#ifdef __arm__
/* The control interrupt, from a vector of tests/c/startup.c. */
void pend_sv(void);
void pend_sv(void)
{
    drive_interrupt();
}

static void interrupt(void)
{
    *(volatile uint32_t *)0xE000ED04u = 1u << 28;
    __asm__ volatile("dsb\n\tisb" ::: "memory");
}
#else
static void interrupt(void)
{
    drive_interrupt();
}
#endif

static narx_drive_report_t run(unsigned milliseconds)
{
    narx_drive_report_t report;
    unsigned tick;

    for (tick = 0; tick < milliseconds * 10u; tick++) {
        while (waiting < QUEUE && narx_master_poll_frame(&master, ticks * 100u, &to_drive[waiting]) == NARX_OK) {
            waiting++;
        }
        interrupt();
        drive_loop();
    }
    CHECK(narx_master_report(&master, ticks * 100u, &report) == NARX_OK);
    return report;
}

/* Runs until the master's job has ended; returns its result. */
static narx_status_t finish_job(narx_job_failure_t *failure)
{
    narx_status_t end = NARX_NOTHING;

    while (end == NARX_NOTHING) {
        (void)run(1);
        end = narx_master_poll_job(&master, failure);
    }
    return end;
}

/* Runs until the job of the scope or the log has ended; returns its result. */
static narx_status_t finish_record(narx_job_failure_t *failure)
{
    narx_status_t end = NARX_NOTHING;

    while (end == NARX_NOTHING) {
        (void)run(1);
        end = narx_master_poll_record(&master, failure);
    }
    return end;
}

/* A record that the master captures by itself while the motor turns, its download, and settings that are refused. */
static void record_by_job(void)
{
    narx_scope_setup_t setup;
    narx_job_failure_t failure;
    narx_chunk_t chunk;
    uint32_t words = 0;
    uint32_t downloaded = 0;

    memset(&setup, 0, sizeof setup);
    setup.channels = 5;
    setup.samples = 60;
    setup.prescaler = 1;
    setup.before = 20;
    CHECK(narx_master_poll_record(&master, NULL) == NARX_NOTHING);
    CHECK(narx_master_begin_record(&master, NARX_JOB_KIND_CAPTURE_SCOPE, NULL, 0) == NARX_ERROR_NULL);
    CHECK(narx_master_begin_record(&master, NARX_JOB_KIND_START, &setup, 0) == NARX_ERROR_REQUEST);
    CHECK(narx_master_begin_record(&master, NARX_JOB_KIND_CAPTURE_SCOPE, &setup, 1000000u) == NARX_OK);
    CHECK(finish_record(&failure) == NARX_OK);
    CHECK(narx_master_download(&master, NARX_DOWNLOAD_KIND_SCOPE, 0, 120) == NARX_OK);
    while (narx_master_poll_download(&master, &words) == NARX_NOTHING) {
        (void)run(1);
        while (narx_master_poll_chunk(&master, &chunk) == NARX_OK) {
            downloaded = chunk.offset + chunk.length;
        }
    }
    CHECK(words == 120 && downloaded == 120);
    CHECK(narx_master_begin_record(&master, NARX_JOB_KIND_FORCE_SCOPE, NULL, 0) == NARX_OK);
    CHECK(finish_record(&failure) == NARX_ERROR_SCOPE_REFUSED && failure.scope == 3);
    setup.before = 60;
    CHECK(narx_master_begin_record(&master, NARX_JOB_KIND_ARM_SCOPE, &setup, 0) == NARX_OK);
    CHECK(finish_record(&failure) == NARX_ERROR_OUT_OF_RANGE && failure.parameter == NARX_PARAMETER_SCOPE_TRIGGER_PHASE);
    CHECK(narx_master_begin_record(&master, NARX_JOB_KIND_AWAIT_SCOPE, NULL, 1000000u) == NARX_OK);
    CHECK(narx_master_abort_record(&master) == NARX_OK);
    CHECK(finish_record(NULL) == NARX_ERROR_ABORTED);
}

/* A start that the master carries out by itself, and one that another command ends. */
static void start_by_job(uint8_t running)
{
    narx_job_failure_t failure;
    narx_drive_report_t report;

    CHECK(narx_master_poll_job(&master, NULL) == NARX_NOTHING);
    CHECK(narx_master_begin(&master, NARX_JOB_KIND_START, RPM) == NARX_OK);
    CHECK(finish_job(&failure) == NARX_OK);
    CHECK(narx_master_report(&master, ticks * 100u, &report) == NARX_OK && report.state == running);
    record_by_job();
    CHECK(narx_master_begin(&master, NARX_JOB_KIND_REBOOT, 0) == NARX_OK);
    CHECK(finish_job(&failure) == NARX_ERROR_NO_ANSWER && failure.state == 255);
    CHECK(narx_master_stop(&master) == NARX_OK);
    CHECK(run(300).state == NARX_STATE_STANDBY);
    CHECK(narx_master_begin(&master, NARX_JOB_KIND_START, -RPM) == NARX_OK);
    (void)run(20);
    CHECK(narx_master_stop(&master) == NARX_OK);
    CHECK(narx_master_poll_job(&master, NULL) == NARX_ERROR_ABORTED);
    CHECK(narx_master_begin(&master, 3, 0) == NARX_ERROR_REQUEST);
}

int main(int argc, char **argv)
{
    const int sensorless = argc > 1 && strcmp(argv[1], "--sensorless") == 0;
    const uint8_t running = sensorless ? NARX_STATE_SENSORLESS_CLOSED_LOOP : NARX_STATE_HALL_CLOSED_LOOP;
    narx_drive_report_t report;
    narx_stored_t stored[STORED];
    uint32_t count;

    CHECK(bench_init(sensorless) == 0);
    for (count = 0; count < STORED && bench_parameter(count, &stored[count].number, &stored[count].value); count++) {
    }
    CHECK(count > 10 && count < STORED);
    CHECK(drive_init(NULL, stored, count) == NARX_OK);
    CHECK(narx_master_init(&master, sizeof master, NULL) == NARX_OK);
    CHECK(narx_master_stop(&master) == NARX_OK);
    CHECK(run(700).state == NARX_STATE_STANDBY);
    CHECK(narx_master_start(&master, RPM) == NARX_OK);
    report = run(sensorless ? 2000 : 1300);
    CHECK(report.state == running && report.faults == 0 && report.accepted_speed == RPM);
    CHECK(fabs(bench_rpm() - RPM) < 0.02 * RPM);
    CHECK(report.speed > RPM - 60 && report.speed < RPM + 60);
    printf("digest %08lx after %lu ticks: %s at %d rpm\n", (unsigned long)digest, (unsigned long)ticks,
           report.state == running ? "running" : "not running", report.speed);
    CHECK(narx_master_stop(&master) == NARX_OK);
    CHECK(run(300).state == NARX_STATE_STANDBY);
    start_by_job(running);
    return report_checks();
}
