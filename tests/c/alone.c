/* The control tick alone, as a program for bare metal links it: coefficients in flash, samples in, PWM out.
 * It is measured, not run: `cargo xtask sizes`. */

#include "narx.h"

extern const narx_coefficients_t coefficients;
const narx_coefficients_t coefficients = {0};

volatile narx_samples_t samples;
volatile narx_pwm_command_t applied;
volatile int32_t speed;

static narx_motor_t motor;

/* The control interrupt. */
void control(void);
void control(void)
{
    narx_samples_t measured = samples;
    narx_pwm_command_t command;
    narx_motor_step(&motor, &measured, &command);
    applied = command;
}

int main(void)
{
    if (narx_motor_init(&motor, sizeof motor, &coefficients) != NARX_OK) {
        return 1;
    }
    for (;;) {
        narx_motor_handle_command(&motor, speed != 0, speed);
        narx_motor_handle_inputs(&motor, 25 * NARX_Q16_ONE, 0);
        control();
    }
}
