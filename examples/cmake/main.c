/* A drive without a motor, on this machine: one second of control ticks, and the frames that it sends. In a
 * firmware narx_drive_step is the control interrupt's, everything else the main loop's. */

#include <narx.h>

#include <inttypes.h>
#include <stdio.h>

/* All memory of the drive. */
static narx_drive_t drive;

int main(void)
{
    const narx_status_t status = narx_drive_init(&drive, sizeof drive, NULL);
    unsigned frames = 0;

    if (status != NARX_OK) {
        fprintf(stderr, "narx_drive_init: %s\n", narx_status_text(status));
        return 1;
    }
    for (uint64_t tick = 0; tick < 10000; tick++) {
        narx_samples_t samples = {0};
        narx_pwm_command_t command;
        narx_frame_t frame;

        samples.tick = tick;
        samples.bus_voltage = 1229;  /* 24 V on the default board */
        samples.bus_current = 2048;  /* none */
        samples.hall = 1;
        (void)narx_drive_step(&drive, &samples, &command);
        (void)narx_drive_run(&drive, tick);
        while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) {
            if (frames++ == 0) {
                printf("tick %" PRIu64 ": the first frame\n", tick);
            }
        }
    }
    printf("%u frames in a second\n", frames);
    return frames > 0 ? 0 : 1;
}
