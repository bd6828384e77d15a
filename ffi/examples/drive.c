/* A whole drive: its control interrupt and its main loop. `board.h` declares the functions of the board. */

#include "board.h"
#include "drive.h"
#include "narx.h"

/* All memory of the drive; nothing else is allocated. */
static narx_drive_t drive;
static narx_scope_t scope;

/* Call it at power-up, with interrupts off. `stored` holds the `count` parameters of your store. */
narx_status_t drive_init(const narx_board_t *board, const narx_stored_t *stored, size_t count)
{
    const narx_status_t status = narx_drive_init_stored(&drive, sizeof drive, board, NULL, stored, count);

    return status != NARX_OK ? status : narx_drive_attach_scope(&drive, &scope, sizeof scope);
}

/* The control interrupt, once a PWM period. It may interrupt drive_loop at any instruction. On an error the
 * command is coast. */
void drive_interrupt(void)
{
    narx_samples_t samples;
    narx_pwm_command_t command;

    board_sample(&samples);
    (void)narx_drive_step(&drive, &samples, &command);
    board_apply(&command);
}

/* One pass of the main loop. */
void drive_loop(void)
{
    static uint64_t looked;
    const uint64_t now = board_ticks();
    narx_frame_t frame;

    while (board_receive(&frame)) {
        (void)narx_drive_handle_frame(&drive, &frame);
    }
    if (now - looked >= 100) {
        narx_slow_inputs_t inputs;

        looked = now;
        board_slow_inputs(&inputs);
        (void)narx_drive_handle_inputs(&drive, &inputs);
    }
    (void)narx_drive_run(&drive, now);
    while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) {
        board_send(&frame);
    }
    /* Frames of a download: more than one in the controller would delay the other messages. */
    if (board_sends_at_once() && narx_drive_poll_bulk_frame(&drive, &frame) == NARX_OK) {
        board_send(&frame);
    }
    if (narx_drive_take_reboot(&drive) == NARX_OK) {
        board_reset();
    }
}
