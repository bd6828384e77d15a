/* A simulated motor in place of a board: tests/c/bench. One thread may use it. */

#ifndef BENCH_H
#define BENCH_H

#include <stdint.h>

#include "narx.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Puts the motor on the bench, with sensors (`sensorless` 0) or without. Not 0 if that cannot be. */
int bench_init(int sensorless);

/* Of the parameters that commissioning has changed, that with place `index`, from 0 on: 1 and its number and raw value, or 0 behind the last. */
int bench_parameter(uint32_t index, uint16_t *number, int32_t *value);

/* Samples of this period. */
void bench_sample(narx_samples_t *samples);

/* Applies the answer to them and ends the period. */
void bench_finish(const narx_pwm_command_t *command);

/* The shaft's true speed, mechanical rpm. */
double bench_rpm(void);

#ifdef __cplusplus
}
#endif

#endif
