/* The master: another board that commands a drive, reads its measurements and sets its parameters. It
 * replaces a hand-written sender of REQUEST_WORD with its table of identifiers. Here a loop exchanges the
 * frames of drive and master; on a board they pass through your CAN controller. */

#include <stdio.h>
#include <string.h>

#include "narx.h"

static narx_master_t master;
static narx_drive_t drive;
static uint64_t tick;

/* Runs control ticks of 100 us of a drive at rest on 24 V, and its master. Both take the time as an
 * argument. */
static void run(int ticks)
{
    narx_samples_t samples;
    narx_pwm_command_t command;
    narx_frame_t frame;

    memset(&samples, 0, sizeof samples);
    samples.bus_voltage = 1229;
    samples.bus_current = 2048;
    samples.hall = 1;
    for (; ticks > 0; ticks--, tick++) {
        const uint64_t now = tick * 100u;

        samples.tick = tick;
        (void)narx_drive_step(&drive, &samples, &command);
        while (narx_master_poll_frame(&master, now, &frame) == NARX_OK) {
            (void)narx_drive_handle_frame(&drive, &frame);
        }
        (void)narx_drive_run(&drive, tick);
        while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) {
            (void)narx_master_handle_frame(&master, &frame, now);
        }
    }
}

int main(void)
{
    narx_request_t request = {NARX_REQUEST_KIND_WRITE, NARX_PARAMETER_MOTOR_POLE_PAIRS, 7};
    narx_answer_t answer;
    narx_message_t measured;
    narx_drive_report_t report;

    if (narx_drive_init(&drive, sizeof drive, NULL) != NARX_OK || narx_master_init(&master, sizeof master, NULL) != NARX_OK) {
        return 1;
    }
    /* Requests Standby and repeats it: the drive sends its words and measurements as long as it receives
     * set-points. */
    (void)narx_master_stop(&master);
    run(10000);
    if (narx_master_report(&master, tick * 100u, &report) != NARX_OK || report.state != NARX_STATE_STANDBY
        || narx_master_measurement(&master, NARX_MESSAGE_MEASUREMENT_2, &measured, NULL) != NARX_OK) {
        return 1;
    }
    printf("Standby at %ld of 0.01 V\n", (long)measured.fields.measurement_2.hv_voltage);

    /* A request has exactly one answer: done, refused with a reason, or not answered in time. */
    (void)narx_master_request(&master, &request);
    run(200);
    if (narx_master_poll_answer(&master, &answer) != NARX_OK || answer.status != NARX_OK) {
        return 1;
    }
    printf("%ld pole pairs\n", (long)answer.value);
    request.value = 1000;
    (void)narx_master_request(&master, &request);
    run(200);
    (void)narx_master_poll_answer(&master, &answer);
    printf("1000: %s; still %ld\n", narx_status_text(answer.status), (long)answer.value);
    return answer.status == NARX_ERROR_OUT_OF_RANGE && answer.value == 7 ? 0 : 1;
}
