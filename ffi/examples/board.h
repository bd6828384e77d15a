/* Functions of the board that examples/drive.c calls: write them for yours. */

#ifndef BOARD_H
#define BOARD_H

#include "narx.h"

/* Reads converters, hall lines and captured edges of this PWM period; called from the control interrupt. */
void board_sample(narx_samples_t *samples);

/* Writes duty, sampling instant and switch patterns to the timer; called from the control interrupt. */
void board_apply(const narx_pwm_command_t *command);

/* Takes the next frame that the CAN controller has received: returns 1, or 0 for none. */
int board_receive(narx_frame_t *frame);

/* Passes a frame to the CAN controller. */
void board_send(const narx_frame_t *frame);

/* 1 if no more than one frame waits in the controller, the one that is on the bus. */
int board_sends_at_once(void);

/* Reads temperatures, rails and the other slow inputs. */
void board_slow_inputs(narx_slow_inputs_t *inputs);

/* Returns the number of PWM periods since power-up. */
uint64_t board_ticks(void);

/* Restarts the processor. */
void board_reset(void);

#endif
