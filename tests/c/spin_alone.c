/* The control tick alone turns the simulated motor, with coefficients that are built here from parameters. With hall sensors a second one
 * runs beside it, with the coefficients that `narx` has printed for the same motor: its commands are the same. Prints a line of figures
 * that are the same, bit for bit, wherever it runs; exit code 0 if the motor runs as it was asked to.
 *
 *     spin_alone [--sensorless]
 */

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "bench.h"
#include "check.h"
#include "coefficients.h"
#include "narx.h"

enum { RPM = 2000, POLE_PAIRS = 4, STORED = 64, STANDBY = 0, DRIVE = 1 };

static narx_motor_t motor;
static narx_motor_t printed;
/* Both have the same coefficients. */
static int alike;

/* FNV-1a of everything that was applied. */
static uint32_t digest = 2166136261u;

static void note(uint32_t value)
{
    digest = (digest ^ value) * 16777619u;
}

static narx_coefficients_t built(void)
{
    static narx_stored_t stored[STORED];
    narx_coefficients_t coefficients_built;
    narx_parameter_error_t error;
    uint32_t count = 0;

    while (count < STORED && bench_parameter(count, &stored[count].number, &stored[count].value)) {
        count++;
    }
    CHECK(narx_coefficients_build(&coefficients_built, NULL, stored, count, &error) == NARX_OK);
    /* Under voltage beyond over voltage: the error names the parameter, and nothing is written. */
    stored[0].number = NARX_PARAMETER_UNDER_VOLTAGE;
    stored[0].value = 60000;
    memset(&error, 0, sizeof error);
    CHECK(narx_coefficients_build(&coefficients_built, NULL, stored, 1, &error) == NARX_ERROR_PARAMETERS);
    CHECK(error.number == NARX_PARAMETER_UNDER_VOLTAGE && error.value == 60000 && error.max < 60000);
    stored[0].number = 0xFFFF;
    CHECK(narx_coefficients_build(&coefficients_built, NULL, stored, 1, NULL) == NARX_ERROR_UNKNOWN_PARAMETER);
    CHECK(narx_coefficients_build(NULL, NULL, NULL, 0, NULL) == NARX_ERROR_NULL);
    return coefficients_built;
}

/* Runs a time with a request, repeated every 10 ms; writes the last report. */
static void run(uint8_t request, unsigned milliseconds, narx_motor_report_t *report)
{
    const int32_t speed = RPM * POLE_PAIRS * NARX_Q16_ONE / 60;
    unsigned tick;

    for (tick = 0; tick < milliseconds * 10; tick++) {
        narx_samples_t samples;
        narx_pwm_command_t command;
        narx_pwm_command_t other;

        if (tick % 100 == 0) {
            CHECK_QUIETLY(narx_motor_handle_command(&motor, request, speed) == NARX_OK);
            CHECK_QUIETLY(narx_motor_handle_command(&printed, request, speed) == NARX_OK);
            CHECK_QUIETLY(narx_motor_handle_inputs(&motor, 25 * NARX_Q16_ONE, 0) == NARX_OK);
            CHECK_QUIETLY(narx_motor_handle_inputs(&printed, 25 * NARX_Q16_ONE, 0) == NARX_OK);
        }
        bench_sample(&samples);
        CHECK_QUIETLY(narx_motor_step(&motor, &samples, &command) == NARX_OK);
        CHECK_QUIETLY(narx_motor_step(&printed, &samples, &other) == NARX_OK);
        CHECK_QUIETLY(!alike || (other.duty == command.duty && other.step == command.step));
        note(command.duty);
        note(command.sample_at);
        note(command.step);
        note(command.commutation_count);
        bench_finish(&command);
        (void)narx_motor_poll_report(&motor, report);
    }
}

int main(int argc, char **argv)
{
    static narx_coefficients_t from_parameters;
    const int sensorless = argc > 1 && strcmp(argv[argc - 1], "--sensorless") == 0;
    narx_motor_report_t report;
    narx_pwm_command_t command;
    narx_samples_t samples;

    alike = !sensorless;
    memset(&report, 0, sizeof report);
    memset(&samples, 0, sizeof samples);
    command.duty = 1;
    CHECK(narx_motor_step(&motor, &samples, &command) == NARX_ERROR_UNINITIALISED);
    CHECK(command.duty == 0 && command.step == NARX_STEP_COAST);
    CHECK(bench_init(sensorless) == 0);
    from_parameters = built();
    CHECK(narx_motor_init(&motor, sizeof motor / 2, &from_parameters) == NARX_ERROR_SIZE);
    CHECK(narx_motor_init(&motor, sizeof motor, NULL) == NARX_ERROR_NULL);
    CHECK(narx_motor_init(&motor, sizeof motor, &from_parameters) == NARX_OK);
    CHECK(narx_motor_init(&printed, sizeof printed, &coefficients) == NARX_OK);
    CHECK(narx_motor_handle_command(&motor, 4, 0) == NARX_ERROR_ARGUMENT);
    run(STANDBY, 600, &report);
    CHECK(report.state == NARX_STATE_STANDBY && report.faults == 0);
    run(DRIVE, sensorless ? 3000 : 1500, &report);
    CHECK(report.state == (sensorless ? NARX_STATE_SENSORLESS_CLOSED_LOOP : NARX_STATE_HALL_CLOSED_LOOP));
    CHECK(fabs(bench_rpm() - RPM) < RPM / 100.0);
    printf("%.3f rpm, %lu crossings, applied %08lx\n", bench_rpm(), (unsigned long)report.crossings, (unsigned long)digest);
    alike = 0;
    /* New coefficients hold at once: an over-voltage limit below the bus stops the motor. */
    from_parameters.protection.over_voltage.trip = 10 * NARX_Q16_ONE;
    CHECK(narx_motor_change_coefficients(&motor, &from_parameters) == NARX_OK);
    run(DRIVE, 100, &report);
    CHECK(report.state == NARX_STATE_FAULT && report.critical != 0);
    return report_checks();
}
