/* A whole drive: control in an interrupt, everything else in the main loop. board.c is yours to write. */

#include "board.h"

/* All memory of the drive. */
static narx_drive_t drive;

/* PWM periods since power-up. */
static volatile uint64_t ticks;

/* Reads them in the main loop, where the interrupt may come between the two halves. */
static uint64_t now(void)
{
    uint64_t read;

    do {
        read = ticks;
    } while (read != ticks);
    return read;
}

/* On an error the command is coast. */
void control_interrupt(void)
{
    narx_samples_t samples = {0};
    narx_pwm_command_t command;

    board_sample(&samples);
    samples.tick = ticks;
    (void)narx_drive_step(&drive, &samples, &command);
    board_apply(&command);
    ticks = ticks + 1;
}

int main(void)
{
    narx_frame_t frame;

    if (narx_drive_init(&drive, sizeof drive, NULL) != NARX_OK) {
        return 1;
    }
    board_start();
    do {
        while (board_receive(&frame)) {
            (void)narx_drive_handle_frame(&drive, &frame);
        }
        (void)narx_drive_run(&drive, now());
        while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) {
            board_send(&frame);
        }
    } while (board_wait());
    return 0;
}
