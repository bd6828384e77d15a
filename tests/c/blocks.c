/* The blocks' edges: settings that do not build are named with value and range, and every misuse is an error code. What blocks do is shown by
 * ffi/examples. Prints `N passed, N failed`. */

#include <stdint.h>
#include <string.h>

#include "check.h"
#include "narx.h"
#include "ready.h"

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

/* Blocks with the printed coefficients answer what blocks answer that have computed them from settings. */
static void ready_made_coefficients_are_those_of_the_settings(void)
{
    static const narx_pi_settings_t gains = {{16384, 15}, {5 * NARX_IQ24_ONE, 24}, 1000, 0, 6 * NARX_Q16_ONE};
    static const narx_ramp_settings_t slope = {100 * NARX_Q16_ONE, 1000};
    static const narx_commutation_settings_t advance = {500, 8192};
    static const uint8_t codes[6] = {1, 3, 2, 6, 4, 5};
    static narx_pi_t pis[2];
    static narx_ramp_t ramps[2];
    static narx_commutator_t commutators[2];
    static narx_hall_t halls[2];
    static narx_zero_crossing_t detectors[2];
    static narx_fault_t faults[2];
    static narx_state_machine_t machines[2];
    narx_hall_settings_t wiring;
    narx_zero_crossing_settings_t terminals;
    narx_fault_settings_t limits;
    narx_state_settings_t durations;
    narx_samples_t samples;
    narx_evidence_t evidence;
    narx_state_inputs_t inputs;
    narx_applied_t coasting;
    int tick;

    memset(&samples, 0, sizeof samples);
    memset(&evidence, 0, sizeof evidence);
    memset(&inputs, 0, sizeof inputs);
    memset(&coasting, 0, sizeof coasting);
    coasting.step = NARX_STEP_COAST;
    inputs.parameters_fit = 1;
    CHECK(narx_hall_settings_default(&wiring) == NARX_OK && narx_zero_crossing_settings_default(&terminals) == NARX_OK);
    CHECK(narx_fault_settings_default(&limits) == NARX_OK && narx_state_settings_default(&durations) == NARX_OK);
    CHECK(narx_pi_init_ready(&pis[0], sizeof pis[0], NULL) == NARX_ERROR_NULL);
    CHECK(narx_pi_init_ready(&pis[0], 8, &pi_ready) == NARX_ERROR_SIZE);
    CHECK(narx_pi_init(&pis[0], sizeof pis[0], &gains, NULL) == NARX_OK);
    CHECK(narx_pi_init_ready(&pis[1], sizeof pis[1], &pi_ready) == NARX_OK);
    CHECK(narx_ramp_init(&ramps[0], sizeof ramps[0], &slope, NULL) == NARX_OK);
    CHECK(narx_ramp_init_ready(&ramps[1], sizeof ramps[1], &ramp_ready) == NARX_OK);
    CHECK(narx_commutation_init(&commutators[0], sizeof commutators[0], &advance, NULL) == NARX_OK);
    CHECK(narx_commutation_init_ready(&commutators[1], sizeof commutators[1], &commutation_ready) == NARX_OK);
    CHECK(narx_hall_init(&halls[0], sizeof halls[0], &wiring, NULL) == NARX_OK);
    CHECK(narx_hall_init_ready(&halls[1], sizeof halls[1], &hall_ready) == NARX_OK);
    CHECK(narx_zero_crossing_init(&detectors[0], sizeof detectors[0], &terminals, NULL) == NARX_OK);
    CHECK(narx_zero_crossing_init_ready(&detectors[1], sizeof detectors[1], &zero_crossing_ready) == NARX_OK);
    CHECK(narx_fault_init(&faults[0], sizeof faults[0], &limits, NULL) == NARX_OK);
    CHECK(narx_fault_init_ready(&faults[1], sizeof faults[1], &fault_ready) == NARX_OK);
    CHECK(narx_state_init(&machines[0], sizeof machines[0], &durations, NULL) == NARX_OK);
    CHECK(narx_state_init_ready(&machines[1], sizeof machines[1], &state_ready) == NARX_OK);
    for (tick = 0; tick < 6000; tick++) {
        const int sector = tick / 25 % 6;
        int32_t output[2];
        int32_t value[2];
        narx_hall_reading_t reading[2];
        narx_steps_t steps[2];
        narx_zero_crossing_reading_t received[2];
        narx_faults_t words[2];
        narx_change_t change[2];
        narx_status_t fired[2];
        int i;

        /* A rotor that turns: the terminals of a coasting motor, one phase high and one low. */
        for (i = 0; i < 3; i++) {
            samples.phase_voltage[i] = (uint16_t)((sector + 6 - 2 * i) % 6 < 3 ? 400 : 0);
        }
        evidence.bus_voltage = tick < 3000 ? 24 * NARX_Q16_ONE : 70 * NARX_Q16_ONE;
        for (i = 0; i < 2; i++) {
            CHECK_QUIETLY(narx_pi_step(&pis[i], (500 - tick) * 256, &output[i]) == NARX_OK);
            CHECK_QUIETLY(narx_ramp_step(&ramps[i], tick < 3000 ? 90 * NARX_Q16_ONE : 0, &value[i]) == NARX_OK);
            CHECK_QUIETLY(narx_hall_step(&halls[i], codes[sector], NULL, 0, &reading[i]) == NARX_OK);
            CHECK_QUIETLY(narx_commutation_step(&commutators[i], reading[i].angle, reading[i].turn_speed, 0, &steps[i]) == NARX_OK);
            CHECK_QUIETLY(narx_zero_crossing_step(&detectors[i], &samples, &coasting, 0, &received[i]) == NARX_OK);
            CHECK_QUIETLY(narx_fault_step(&faults[i], &evidence, &words[i]) >= 0);
            fired[i] = narx_state_step(&machines[i], &inputs, &change[i]);
        }
        CHECK_QUIETLY(output[0] == output[1] && value[0] == value[1]);
        CHECK_QUIETLY(reading[0].angle == reading[1].angle && reading[0].speed == reading[1].speed);
        CHECK_QUIETLY(steps[0].step == steps[1].step && steps[0].commutation_count == steps[1].commutation_count);
        CHECK_QUIETLY(received[0].angle == received[1].angle && received[0].speed == received[1].speed);
        CHECK_QUIETLY(words[0].word == words[1].word);
        CHECK_QUIETLY(fired[0] == fired[1] && (fired[0] != NARX_OK || change[0].to == change[1].to));
        if (tick == 5999) {
            CHECK(reading[1].speed > 60 * NARX_Q16_ONE && received[1].speed > 60 * NARX_Q16_ONE && words[1].word != 0);
        }
    }
}

int main(void)
{
    settings_are_named();
    storage_is_checked();
    arguments_are_checked();
    ready_made_coefficients_are_those_of_the_settings();
    return report_checks();
}
