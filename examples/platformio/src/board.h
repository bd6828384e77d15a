/* What the board must do for the drive. */

#ifndef BOARD_H
#define BOARD_H

#include <narx.h>

/* The control interrupt, once a PWM period: in main.c, called from the converters' interrupt. */
void control_interrupt(void);

/* Starts timer, converters and CAN; control_interrupt is called from then on. */
void board_start(void);

/* Reads converters and hall lines of this PWM period. Called from the control interrupt. */
void board_sample(narx_samples_t *samples);

/* Writes duty and switch pattern to the timer. Called from the control interrupt. */
void board_apply(const narx_pwm_command_t *command);

/* Takes the next received frame: returns 1, or 0 for none. */
int board_receive(narx_frame_t *frame);

/* Passes a frame to the CAN controller. */
void board_send(const narx_frame_t *frame);

/* Waits for the next interrupt; returns 0 when the program shall end, which firmware never does. */
int board_wait(void);

#endif
