/* The blocks' edges: settings that do not build are named with value and range, and every misuse is an error code. What blocks do is shown by
 * ffi/examples. Prints `N passed, N failed`. */

#include <stdint.h>
#include <string.h>

#include "check.h"
#include "narx.h"

static narx_pi_t pi;
static narx_ramp_t ramp;
static narx_hall_t hall;
static narx_commutator_t commutator;
static narx_zero_crossing_t detector;
static narx_fault_t fault;
static narx_state_machine_t machine;

static void settings_are_named(void)
{
    narx_pi_settings_t gains = {{1 << 20, 20}, {1 << 20, 20}, 10000, -NARX_Q16_ONE, NARX_Q16_ONE};
    narx_ramp_settings_t rate = {0, 10000};
    narx_commutation_settings_t advance = {3001, 0};
    narx_hall_settings_t wiring;
    narx_zero_crossing_settings_t terminals;
    narx_fault_settings_t limits;
    narx_state_settings_t durations;
    narx_setting_error_t error;

    CHECK(narx_pi_init(&pi, sizeof pi, &gains, &error) == NARX_OK);
    gains.minimum = 2 * NARX_Q16_ONE;
    CHECK(narx_pi_init(&pi, sizeof pi, &gains, &error) == NARX_ERROR_SETTING);
    CHECK(strcmp(error.setting, "minimum") == 0 && error.value == gains.minimum && error.max == NARX_Q16_ONE);
    CHECK(error.fraction_bits == 16);
    gains.minimum = 0;
    gains.integral.shift = 63;
    CHECK(narx_pi_init(&pi, sizeof pi, &gains, &error) == NARX_ERROR_SETTING);
    CHECK(strcmp(error.setting, "integral") == 0 && error.value == 63 && error.max == 62);
    gains.integral.shift = 20;
    gains.integral.mantissa = -1;
    CHECK(narx_pi_init(&pi, sizeof pi, &gains, &error) == NARX_ERROR_SETTING);
    CHECK(error.value == -1 && error.max == (1 << 30) - 1);

    CHECK(narx_ramp_init(&ramp, sizeof ramp, &rate, &error) == NARX_ERROR_SETTING);
    CHECK(strcmp(error.setting, "rate") == 0 && error.value == 0 && error.min == 1);

    CHECK(narx_commutation_init(&commutator, sizeof commutator, &advance, &error) == NARX_ERROR_SETTING);
    CHECK(strcmp(error.setting, "advance_cdeg") == 0 && strcmp(error.unit, "0.01 degree") == 0 && error.max == 3000);

    CHECK(narx_hall_settings_default(&wiring) == NARX_OK);
    wiring.order = 6;
    CHECK(narx_hall_init(&hall, sizeof hall, &wiring, &error) == NARX_ERROR_SETTING);
    CHECK(strcmp(error.setting, "order") == 0 && error.value == 6 && error.max == 5);

    CHECK(narx_zero_crossing_settings_default(&terminals) == NARX_OK);
    terminals.pole_pairs = 0;
    CHECK(narx_zero_crossing_init(&detector, sizeof detector, &terminals, &error) == NARX_ERROR_SETTING);
    CHECK(strcmp(error.setting, "pole_pairs") == 0 && error.min == 1 && error.max == 100);

    CHECK(narx_fault_settings_default(&limits) == NARX_OK);
    limits.under_voltage = limits.over_voltage;
    CHECK(narx_fault_init(&fault, sizeof fault, &limits, &error) == NARX_ERROR_SETTING);
    CHECK(strcmp(error.setting, "under_voltage") == 0 && strcmp(error.unit, "V") == 0);
    CHECK(error.max == limits.over_voltage - NARX_Q16_ONE);

    CHECK(narx_state_settings_default(&durations) == NARX_OK);
    durations.tick_rate = 999;
    CHECK(narx_state_init(&machine, sizeof machine, &durations, &error) == NARX_ERROR_SETTING);
    CHECK(strcmp(error.setting, "tick_rate") == 0 && error.min == 1000);
    /* Nobody has to know. */
    CHECK(narx_state_init(&machine, sizeof machine, &durations, NULL) == NARX_ERROR_SETTING);
}

static void storage_is_checked(void)
{
    static narx_ramp_t other;
    static narx_pi_t room[2];
    const narx_pi_settings_t gains = {{1, 0}, {0, 0}, 1000, 0, NARX_Q16_ONE};
    int32_t value = 7;

    /* What has failed to build has not become a block, nor harmed the one that was there. */
    CHECK(narx_ramp_step(&ramp, 1, &value) == NARX_ERROR_UNINITIALISED && value == 7);
    CHECK(narx_pi_step(&pi, 1, &value) == NARX_OK);
    CHECK(narx_hall_step(&hall, 1, NULL, 0, NULL) == NARX_ERROR_NULL);
    CHECK(narx_state_handle_command(&machine, 0, 0) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_fault_acknowledge(&fault) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_zero_crossing_force_step(&detector) == NARX_ERROR_UNINITIALISED);
    CHECK(narx_commutation_reset(&commutator) == NARX_ERROR_UNINITIALISED);

    CHECK(narx_pi_init(NULL, sizeof pi, &gains, NULL) == NARX_ERROR_NULL);
    CHECK(narx_pi_init(&pi, sizeof pi, NULL, NULL) == NARX_ERROR_NULL);
    CHECK(narx_pi_init(&pi, sizeof pi - 8, &gains, NULL) == NARX_ERROR_SIZE);
    CHECK(narx_pi_init((narx_pi_t *)(void *)((char *)room + 1), sizeof pi, &gains, NULL) == NARX_ERROR_ALIGNMENT);
    CHECK(narx_pi_init(&pi, sizeof pi, &gains, NULL) == NARX_OK);
    CHECK(narx_pi_step(&pi, 1, NULL) == NARX_ERROR_NULL);
    CHECK(narx_pi_step(NULL, 1, &value) == NARX_ERROR_NULL);
    CHECK(narx_pi_hold(&pi, NARX_Q16_ONE / 2) == NARX_OK);
    CHECK(narx_pi_step(&pi, 0, &value) == NARX_OK && value == NARX_Q16_ONE / 2);
    /* To an eighth of the way from 1/2 to 0 - 1/4. */
    CHECK(narx_pi_track(&pi, 0, NARX_Q16_ONE / 4) == NARX_OK);
    CHECK(narx_pi_step(&pi, 0, &value) == NARX_OK && value == NARX_Q16_ONE * 13 / 32);
    /* A PI is no ramp. */
    memcpy(&other, &pi, sizeof other);
    CHECK(narx_ramp_set(&other, 0) == NARX_ERROR_UNINITIALISED);
}

static void arguments_are_checked(void)
{
    static const narx_applied_t coasting = {0, NARX_STEP_COAST, 0, {0, 0}, {0, 0}};
    narx_commutation_settings_t advance = {0, 8192};
    narx_hall_settings_t wiring;
    narx_zero_crossing_settings_t terminals;
    narx_fault_settings_t limits;
    narx_hall_reading_t reading;
    narx_zero_crossing_reading_t received;
    narx_applied_t applied = coasting;
    narx_edge_t edges[NARX_EDGES_MAX + 1];
    narx_samples_t samples;
    narx_evidence_t evidence;
    narx_change_t change = {NARX_STATE_STANDBY, NARX_STATE_SENSORLESS_AUTO_RESTART, 0};
    narx_faults_t faults;
    narx_steps_t steps;
    narx_step_t step;
    uint8_t legs[3];

    memset(edges, 0, sizeof edges);
    memset(&samples, 0, sizeof samples);
    memset(&evidence, 0, sizeof evidence);
    CHECK(narx_commutation_step_for(6, 0, &step) == NARX_ERROR_ARGUMENT);
    CHECK(narx_commutation_step_for(0, 2, &step) == NARX_ERROR_ARGUMENT);
    CHECK(narx_commutation_step_for(0, 0, NULL) == NARX_ERROR_NULL);
    CHECK(narx_commutation_step_for(0, 0, &step) == NARX_OK && step == NARX_STEP_AB);
    CHECK(narx_commutation_legs(13, legs) == NARX_ERROR_ARGUMENT);
    /* A switched, B low, C floating. */
    CHECK(narx_commutation_legs(NARX_STEP_AB, legs) == NARX_OK && legs[0] == 2 && legs[1] == 1 && legs[2] == 0);
    CHECK(narx_commutation_init(&commutator, sizeof commutator, &advance, NULL) == NARX_OK);
    CHECK(narx_commutation_step(&commutator, 0, 0, 2, &steps) == NARX_ERROR_ARGUMENT);
    CHECK(narx_commutation_step(&commutator, 0, 0, 0, &steps) == NARX_OK && steps.step != NARX_STEP_COAST);

    CHECK(narx_hall_settings_default(&wiring) == NARX_OK);
    CHECK(narx_hall_init(&hall, sizeof hall, &wiring, NULL) == NARX_OK);
    CHECK(narx_hall_step(&hall, 1, edges, NARX_EDGES_MAX + 1, &reading) == NARX_ERROR_SAMPLES);
    CHECK(narx_hall_step(&hall, 1, NULL, 1, &reading) == NARX_ERROR_NULL);
    edges[0].source = 2;
    CHECK(narx_hall_step(&hall, 1, edges, 1, &reading) == NARX_ERROR_SAMPLES);
    CHECK(narx_hall_step(&hall, 0xF8, NULL, 0, &reading) == NARX_OK && reading.invalid && reading.sector == 255);

    CHECK(narx_zero_crossing_settings_default(&terminals) == NARX_OK);
    CHECK(narx_zero_crossing_init(&detector, sizeof detector, &terminals, NULL) == NARX_OK);
    applied.step = 13;
    CHECK(narx_zero_crossing_step(&detector, &samples, &applied, 0, &received) == NARX_ERROR_ARGUMENT);
    applied = coasting;
    applied.commutation_count = 3;
    CHECK(narx_zero_crossing_step(&detector, &samples, &applied, 0, &received) == NARX_ERROR_ARGUMENT);
    CHECK(narx_zero_crossing_start(&detector, 0, 2) == NARX_ERROR_ARGUMENT);
    CHECK(narx_zero_crossing_step(&detector, &samples, &coasting, 0, &received) == NARX_OK);
    CHECK(!received.running && received.crossing == INT32_MIN && received.commutation == UINT32_MAX);

    CHECK(narx_fault_settings_default(&limits) == NARX_OK);
    CHECK(narx_fault_init(&fault, sizeof fault, &limits, NULL) == NARX_OK);
    evidence.request = 4;
    CHECK(narx_fault_step(&fault, &evidence, &faults) == NARX_ERROR_ARGUMENT);
    evidence.request = 0;
    evidence.sensorless = NARX_CAUSE_OVERSPEED;
    CHECK(narx_fault_step(&fault, &evidence, &faults) == NARX_ERROR_ARGUMENT);
    evidence.sensorless = 0;
    /* No row of Table 7. */
    CHECK(narx_fault_handle_change(&fault, &change, &evidence) == NARX_ERROR_ARGUMENT);
    change.to = NARX_STATE_FAULT;
    CHECK(narx_fault_handle_change(&fault, &change, &evidence) == NARX_OK);
    change.from = 8;
    CHECK(narx_fault_handle_change(&fault, &change, &evidence) == NARX_ERROR_ARGUMENT);
}

int main(void)
{
    settings_are_named();
    storage_is_checked();
    arguments_are_checked();
    return report_checks();
}
