/* What the board must do for the drive. */

#ifndef BOARD_H
#define BOARD_H

#include <narx.h>

/* Interrupt of the converters, and its priority. */
#define BOARD_IRQ 18
#define BOARD_IRQ_PRIORITY 0

/* Starts timer and converters; their interrupt comes once a PWM period from then on. */
void board_start(void);

/* Reads converters and hall lines of this PWM period. Called from the control interrupt. */
void board_sample(narx_samples_t *samples);

/* Writes duty and switch pattern to the timer. Called from the control interrupt. */
void board_apply(const narx_pwm_command_t *command);

#endif
