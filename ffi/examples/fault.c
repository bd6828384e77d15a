/* Limits that qualify a fault, latch it and keep its cause. They replace code that tripped on one noisy
 * sample and did not record the cause:
 *
 *     if (adc_bus > OVER_VOLTAGE) { pwm_off(); fault = 1; }
 */

#include <stdio.h>
#include <string.h>

#include "narx.h"

int main(void)
{
    static narx_fault_t fault;
    narx_fault_settings_t settings;
    narx_evidence_t evidence;
    narx_faults_t faults;
    int tick;
    int tripped = -1;

    if (narx_fault_settings_default(&settings) != NARX_OK) {
        return 1;
    }
    settings.over_voltage = 30 * NARX_Q16_ONE;
    settings.under_voltage = 18 * NARX_Q16_ONE;
    settings.critical_mask = NARX_FAULT_OVER_VOLTAGE | NARX_FAULT_UNDER_VOLTAGE;
    if (narx_fault_init(&fault, sizeof fault, &settings, NULL) != NARX_OK) {
        return 1;
    }
    memset(&evidence, 0, sizeof evidence);
    evidence.driving = 1;
    evidence.torque = 1;
    evidence.temperature = 25 * NARX_Q16_ONE;
    for (tick = 0; tick < 1000; tick++) {
        /* 24 V; one noisy sample; from tick 200 on a brake that feeds energy into the bus. */
        evidence.bus_voltage = (tick == 100 || tick >= 200 ? 61 : 48) * NARX_Q16_ONE / 2;
        if (narx_fault_step(&fault, &evidence, &faults) != NARX_OK) {
            return 1;
        }
        if (faults.present && tripped < 0) {
            tripped = tick;
        }
    }
    printf("tripped in tick %d by cause %04Xh\n", tripped, (unsigned)faults.cause);
    /* 30.5 V are a fault once they have held for 10 ms. */
    if (tripped < 290 || tripped > 310 || faults.cause != NARX_CAUSE_OVER_VOLTAGE
        || narx_fault_acknowledge(&fault) != NARX_ERROR_WRONG_STATE) {
        return 1;
    }
    evidence.bus_voltage = 24 * NARX_Q16_ONE;
    if (narx_fault_step(&fault, &evidence, &faults) != NARX_OK || faults.critical != NARX_FAULT_OVER_VOLTAGE || !faults.causes_gone
        || narx_fault_acknowledge(&fault) != NARX_OK || narx_fault_step(&fault, &evidence, &faults) != NARX_OK) {
        return 1;
    }
    return faults.word == 0 && !faults.present ? 0 : 1;
}
