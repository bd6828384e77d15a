/* Instructions of the blocks' steps and of a drive's, as C calls them, on the emulator: run it with `-icount shift=7`, where one instruction is 3.2
 * counts of the system timer. Prints `NAME MEAN WORST`, the cost of counting taken off.
 */

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "narx.h"

enum { CALLS = 2000, TICKS_A_SECTOR = 25 };

#define TIMER_CONTROL (*(volatile uint32_t *)0xE000E010u)
#define TIMER_RELOAD (*(volatile uint32_t *)0xE000E014u)
#define TIMER_COUNT (*(volatile uint32_t *)0xE000E018u)

static narx_pi_t pi;
static narx_ramp_t ramp;
static narx_hall_t hall;
static narx_commutator_t commutator;
static narx_zero_crossing_t detector;
static narx_fault_t fault;
static narx_state_machine_t machine;
static narx_drive_t drive;

static narx_hall_reading_t reading;

/* What each part is given in call `k`. Not 0 on an error. */

static int step_nothing(uint32_t k)
{
    return k == UINT32_MAX;
}

static int step_pi(uint32_t k)
{
    int32_t output;

    return narx_pi_step(&pi, (int32_t)(k % 97u) * 700 - 30000, &output) != NARX_OK;
}

static int step_ramp(uint32_t k)
{
    int32_t value;

    return narx_ramp_step(&ramp, k % 1000u < 500u ? 10 * NARX_Q16_ONE : 0, &value) != NARX_OK;
}

static int step_hall(uint32_t k)
{
    static const uint8_t codes[6] = {1, 3, 2, 6, 4, 5};
    narx_edge_t edge = {0x8000, NARX_EDGE_SOURCE_HALL, 0};
    const uint8_t code = codes[k / TICKS_A_SECTOR % 6u];

    edge.code = code;
    return narx_hall_step(&hall, code, &edge, k % TICKS_A_SECTOR == 0 && k != 0, &reading) != NARX_OK;
}

static int step_commutation(uint32_t k)
{
    narx_steps_t steps;

    /* A turn in 150 ticks. */
    return narx_commutation_step(&commutator, k * 28633115u, 28633115, 0, &steps) != NARX_OK;
}

static int step_zero_crossing(uint32_t k)
{
    static const narx_applied_t coasting = {0xC000, NARX_STEP_COAST, 0, {0, 0}, {0, 0}};
    narx_zero_crossing_reading_t received;
    narx_samples_t samples;
    uint32_t phase;

    memset(&samples, 0, sizeof samples);
    samples.bus_voltage = 1229;
    for (phase = 0; phase < 3; phase++) {
        const uint32_t x = (k * 328u - phase * 21845u) & 0xFFFFu;

        samples.phase_voltage[phase] = (uint16_t)(100u + (x < 32768u ? x : 65535u - x) / 82u);
    }
    return narx_zero_crossing_step(&detector, &samples, &coasting, 0, &received) != NARX_OK;
}

static int step_fault(uint32_t k)
{
    narx_evidence_t evidence;
    narx_faults_t faults;

    memset(&evidence, 0, sizeof evidence);
    evidence.bus_voltage = (int32_t)(k % 64u < 32u ? 24u : 59u) * NARX_Q16_ONE;
    evidence.driving = 1;
    return narx_fault_step(&fault, &evidence, &faults) != NARX_OK;
}

static int step_state(uint32_t k)
{
    static const narx_state_inputs_t inputs = {0, 0, 1, 1, 0, 1};
    narx_change_t change;

    (void)k;
    return narx_state_step(&machine, &inputs, &change) < 0;
}

static int step_drive(uint32_t k)
{
    narx_samples_t samples;
    narx_pwm_command_t command;

    memset(&samples, 0, sizeof samples);
    samples.tick = k;
    samples.bus_voltage = 1229;
    samples.bus_current = 2048;
    samples.hall = 1;
    return narx_drive_step(&drive, &samples, &command) != NARX_OK;
}

static int initialised(void)
{
    static const narx_pi_settings_t gains = {{1 << 20, 20}, {1 << 20, 20}, 10000, -NARX_Q16_ONE, NARX_Q16_ONE};
    static const narx_ramp_settings_t rate = {100 * NARX_Q16_ONE, 10000};
    static const narx_commutation_settings_t advance = {0, 8192};
    narx_hall_settings_t wiring;
    narx_zero_crossing_settings_t terminals;
    narx_fault_settings_t limits;
    narx_state_settings_t durations;

    return narx_hall_settings_default(&wiring) == NARX_OK && narx_zero_crossing_settings_default(&terminals) == NARX_OK
        && narx_fault_settings_default(&limits) == NARX_OK && narx_state_settings_default(&durations) == NARX_OK
        && narx_pi_init(&pi, sizeof pi, &gains, NULL) == NARX_OK && narx_ramp_init(&ramp, sizeof ramp, &rate, NULL) == NARX_OK
        && narx_hall_init(&hall, sizeof hall, &wiring, NULL) == NARX_OK
        && narx_commutation_init(&commutator, sizeof commutator, &advance, NULL) == NARX_OK
        && narx_zero_crossing_init(&detector, sizeof detector, &terminals, NULL) == NARX_OK
        && narx_fault_init(&fault, sizeof fault, &limits, NULL) == NARX_OK
        && narx_state_init(&machine, sizeof machine, &durations, NULL) == NARX_OK
        && narx_drive_init(&drive, sizeof drive, NULL) == NARX_OK;
}

/* Between two counts of the timer, which counts down. */
static uint32_t instructions(uint32_t before, uint32_t after)
{
    return (((before - after) & 0xFFFFFFu) * 10u + 16u) / 32u;
}

struct cost {
    uint32_t mean;
    uint32_t worst;
};

static struct cost counted(int (*step)(uint32_t), int *errors)
{
    struct cost cost = {0, 0};
    uint32_t k;

    for (k = 0; k < CALLS; k++) {
        const uint32_t before = TIMER_COUNT;
        const int error = step(k);
        const uint32_t taken = instructions(before, TIMER_COUNT);

        *errors += error;
        cost.mean += taken;
        cost.worst = taken > cost.worst ? taken : cost.worst;
    }
    cost.mean /= CALLS;
    return cost;
}

int main(void)
{
    static const struct {
        const char *name;
        int (*step)(uint32_t);
    } parts[] = {
        {"pi", step_pi},
        {"ramp", step_ramp},
        {"hall", step_hall},
        {"commutation", step_commutation},
        {"zero_crossing", step_zero_crossing},
        {"fault", step_fault},
        {"state", step_state},
        {"drive", step_drive},
    };
    int errors = !initialised();
    struct cost nothing;
    size_t i;

    TIMER_RELOAD = 0xFFFFFFu;
    TIMER_COUNT = 0;
    TIMER_CONTROL = 5;
    nothing = counted(step_nothing, &errors);
    for (i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        const struct cost cost = counted(parts[i].step, &errors);

        printf("%s %lu %lu\n", parts[i].name, (unsigned long)(cost.mean - nothing.mean),
               (unsigned long)(cost.worst - nothing.worst));
    }
    return errors == 0 ? 0 : 1;
}
