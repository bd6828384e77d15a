/* A whole drive under Zephyr: control in an interrupt without the kernel, the node in the main thread, CAN by
 * Zephyr's driver. */

#include <string.h>

#include <zephyr/device.h>
#include <zephyr/drivers/can.h>
#include <zephyr/irq.h>
#include <zephyr/kernel.h>

#include "board.h"

static const struct device *const bus = DEVICE_DT_GET(DT_CHOSEN(zephyr_canbus));
CAN_MSGQ_DEFINE(arrived, 32);

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

/* The control interrupt, once a PWM period. It has zero latency, so it calls nothing of the kernel. On an error
 * the command is coast. */
ISR_DIRECT_DECLARE(control_interrupt)
{
    narx_samples_t samples = {0};
    narx_pwm_command_t command;

    board_sample(&samples);
    samples.tick = ticks;
    (void)narx_drive_step(&drive, &samples, &command);
    board_apply(&command);
    ticks = ticks + 1;
    return 0;
}

static void receive(void)
{
    struct can_frame from;

    while (k_msgq_get(&arrived, &from, K_NO_WAIT) == 0) {
        narx_frame_t frame = {.id = from.id, .length = from.dlc};

        frame.extended = (from.flags & CAN_FRAME_IDE) != 0;
        frame.remote = (from.flags & CAN_FRAME_RTR) != 0;
        memcpy(frame.data, from.data, sizeof frame.data);
        (void)narx_drive_handle_frame(&drive, &frame);
    }
}

static void send(void)
{
    narx_frame_t frame;

    while (narx_drive_poll_frame(&drive, &frame) == NARX_OK) {
        struct can_frame to = {.id = frame.id, .dlc = frame.length};

        to.flags = (frame.extended ? CAN_FRAME_IDE : 0) | (frame.remote ? CAN_FRAME_RTR : 0);
        memcpy(to.data, frame.data, sizeof frame.data);
        /* A frame that finds no room within 1 ms is lost, as on a bus that nobody listens to. */
        (void)can_send(bus, &to, K_MSEC(1), NULL, NULL);
    }
}

int main(void)
{
    const struct can_filter all = {.flags = CAN_FILTER_IDE};

    if (!device_is_ready(bus) || can_set_bitrate(bus, 500000) != 0
        || can_add_rx_filter_msgq(bus, &arrived, &all) < 0 || can_start(bus) != 0) {
        printk("no CAN\n");
        return 1;
    }
    if (narx_drive_init(&drive, sizeof drive, NULL) != NARX_OK) {
        return 1;
    }
    IRQ_DIRECT_CONNECT(BOARD_IRQ, BOARD_IRQ_PRIORITY, control_interrupt, IRQ_ZERO_LATENCY);
    irq_enable(BOARD_IRQ);
    board_start();
    for (;;) {
        receive();
        (void)narx_drive_run(&drive, now());
        send();
        k_sleep(K_MSEC(1));
    }
}
