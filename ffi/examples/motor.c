/* The control tick alone: samples in, PWM commands out. No bus, no parameters, no main loop: for a driver that
 * has its own, on a processor with little flash. `coefficients.h` was printed by
 *
 *     narx coefficients --motor bly172s-24v --mode hall
 *
 * Here a rotor that is turned by hand shows its codes, and the drive commutates after them. */

#include <stdio.h>

#include "coefficients.h"
#include "narx.h"

enum { TICKS_A_SECOND = 10000, TICKS_A_SECTOR = 25, STANDBY = 0, DRIVE = 1 };

/* The code of each sector, 60 degrees each, lines A, B, C in bits 0, 1, 2. */
static const uint8_t codes[6] = {1, 3, 2, 6, 4, 5};

static narx_motor_t motor;
static narx_pwm_command_t command;
static narx_samples_t samples;

/* The control interrupt, once a PWM period. */
static narx_status_t control(void)
{
    samples.tick++;
    samples.hall = codes[samples.tick / TICKS_A_SECTOR % 6];
    return narx_motor_step(&motor, &samples, &command);
}

/* The pattern at the end of the period. */
static narx_step_t pattern(void)
{
    return command.commutation_count > 0 ? command.commutations[command.commutation_count - 1].step : command.step;
}

/* Runs a time with a request, which is repeated every 10 ms; returns the number of pattern changes. */
static int run(uint8_t request, int ticks)
{
    const int32_t speed = narx_q16_from_milli(100000); /* 100 electrical rev/s */
    int changes = 0;
    int tick;

    for (tick = 0; tick < ticks; tick++) {
        const narx_step_t before = pattern();

        if (tick % 100 == 0
            && (narx_motor_handle_command(&motor, request, speed) != NARX_OK
                || narx_motor_handle_inputs(&motor, 25 * NARX_Q16_ONE, 0) != NARX_OK)) {
            return -1;
        }
        if (control() != NARX_OK) {
            return -1;
        }
        changes += pattern() != before;
    }
    return changes;
}

int main(void)
{
    narx_board_t board;
    narx_motor_report_t report;
    int changes;

    if (narx_board_default(&board) != NARX_OK || narx_motor_init(&motor, sizeof motor, &coefficients) != NARX_OK) {
        return 1;
    }
    samples.bus_voltage = (uint16_t)(24000000 / board.bus_voltage.micro_per_code);
    samples.bus_current = board.bus_current.zero;
    if (run(STANDBY, TICKS_A_SECOND) < 0 || narx_motor_poll_report(&motor, &report) != NARX_OK
        || report.state != NARX_STATE_STANDBY) {
        return 1;
    }
    changes = run(DRIVE, TICKS_A_SECOND);
    if (narx_motor_poll_report(&motor, &report) != NARX_OK) {
        return 1;
    }
    printf("%ld mrev/s, duty %d, %d pattern changes in a second\n", (long)narx_milli_from_q16(report.speed_hall),
           command.duty, changes);
    /* 10 000 / (6 x 25) = 66.667 rev/s, slower than asked for: there is voltage on the motor. */
    return report.state == NARX_STATE_HALL_CLOSED_LOOP && narx_milli_from_q16(report.speed_hall) / 10 == 6666
                   && command.duty > 0 && changes >= 390 && changes <= 401
               ? 0
               : 1;
}
