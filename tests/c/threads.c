/* Both halves of one drive at once on two threads, for a thread sanitizer: nothing orders them but the drive's own queues.
 * The tick half records with the scope, the background half reads the record, sets parameters and takes frames.
 *
 *     threads            the halves as narx.h allows them; exit code 0
 *     threads --misuse   two threads in the tick half, which it forbids: what a sanitizer has to see
 */

#include <pthread.h>
#include <sched.h>
#include <stdio.h>
#include <string.h>

#include "narx.h"

enum { TICKS = 20000, APART = 20 };

static narx_drive_t drive;
static narx_scope_t scope;

/* How far either half is. Neither runs away from the other, whatever the machine does; relaxed, so that this orders nothing else. */
static long ticks;
static long passes;

static void keep_up(long *mine, const long *other)
{
    const long now = __atomic_add_fetch(mine, 1, __ATOMIC_RELAXED);

    while (__atomic_load_n(other, __ATOMIC_RELAXED) < now - APART) {
        sched_yield();
    }
}

/* A board at rest: 24 V on the bus, no current, rotor in sector 0. */
static narx_samples_t at_rest(void)
{
    narx_samples_t samples;

    memset(&samples, 0, sizeof samples);
    samples.bus_voltage = 1229;
    samples.bus_current = 2048;
    samples.hall = 1;
    return samples;
}

/* A thread in the tick half: how many of its calls failed, how far it is, and how far the other one. */
struct half {
    long failed;
    long *mine;
    const long *other;
};

/* The control interrupt's part. */
static void *tick_half(void *thread)
{
    narx_samples_t samples = at_rest();
    narx_pwm_command_t command;
    struct half *half = thread;
    long tick;

    for (tick = 0; tick < TICKS; tick++) {
        samples.tick = (uint64_t)tick;
        half->failed += narx_drive_step(&drive, &samples, &command) != NARX_OK;
        keep_up(half->mine, half->other);
    }
    return NULL;
}

/* What the background half has seen. */
struct seen {
    long failed;
    long frames;
    long words;
    int32_t state;
};

static struct seen background_half(void)
{
    struct seen seen = {0, 0, 0, -1};
    narx_frame_t request = {0x0AAD5202u, 1, 0, 8, {0}};
    narx_frame_t trigger = {0x0AAD5270u, 1, 0, 8, {0}};
    narx_frame_t download = {0x0AAD5470u, 1, 0, 8, {0}};
    narx_frame_t frame;
    int32_t value;
    long pass;

    for (pass = 0; pass < TICKS; pass++) {
        if (pass % 200 == 0) {
            seen.failed += narx_drive_handle_frame(&drive, &request) != NARX_OK;
        }
        /* Armed, forced, read, and again. */
        if (pass % 400 == 0 || pass % 400 == 20) {
            seen.failed += narx_drive_handle_frame(&drive, &trigger) != NARX_OK;
        } else if (pass % 400 == 200) {
            seen.failed += narx_drive_handle_frame(&drive, &download) != NARX_OK;
        }
        /* Coefficients for the tick. */
        if (pass % 100 == 0) {
            seen.failed += narx_drive_set_parameter(&drive, NARX_PARAMETER_SPEED_RATE, 100 + pass % 7) != NARX_OK;
        }
        seen.failed += narx_drive_run(&drive, (uint64_t)pass) != NARX_OK;
        seen.failed += narx_drive_get_parameter(&drive, NARX_PARAMETER_DRIVE_STATE, &value) != NARX_OK;
        seen.state = value;
        while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) {
            seen.frames++;
        }
        while (narx_drive_poll_bulk_frame(&drive, &frame) == NARX_OK) {
            seen.words += 3;
        }
        keep_up(&passes, &ticks);
    }
    return seen;
}

int main(int argc, char **argv)
{
    const int misuse = argc > 1 && strcmp(argv[1], "--misuse") == 0;
    struct seen seen;
    struct half tick = {0, &ticks, &passes};
    long failed;
    pthread_t thread;

    if (narx_drive_init(&drive, sizeof drive, NULL) != NARX_OK
        || narx_drive_attach_scope(&drive, &scope, narx_scope_size(64)) != NARX_OK
        || narx_drive_set_parameter(&drive, NARX_PARAMETER_SCOPE_SAMPLES, 21) != NARX_OK
        || pthread_create(&thread, NULL, tick_half, &tick) != 0) {
        return 1;
    }
    if (misuse) {
        struct half second = {0, &passes, &ticks};

        tick_half(&second);
        pthread_join(thread, NULL);
        return 0;
    }
    seen = background_half();
    pthread_join(thread, NULL);
    failed = tick.failed + seen.failed;
    printf("%d ticks, %ld calls failed, %ld frames, %ld words of the scope, state %d\n", (int)TICKS, failed,
           seen.frames, seen.words, (int)seen.state);
    return failed == 0 && seen.frames > 100 && seen.words > 60 && seen.state == NARX_STATE_STANDBY ? 0 : 1;
}
