/* See kernel.h. */

#ifndef ZEPHYR_DRIVERS_CAN_H
#define ZEPHYR_DRIVERS_CAN_H

#include <stdint.h>
#include <zephyr/device.h>
#include <zephyr/kernel.h>

#define CAN_FRAME_IDE 1
#define CAN_FRAME_RTR 2
#define CAN_FILTER_IDE 1

struct can_frame {
    uint32_t id;
    uint8_t dlc;
    uint8_t flags;
    uint8_t data[8];
};

struct can_filter {
    uint32_t id;
    uint32_t mask;
    uint8_t flags;
};

typedef void (*can_tx_callback_t)(const struct device *device, int error, void *user);

#define CAN_MSGQ_DEFINE(name, count) static struct k_msgq name = {(count)}

int can_set_bitrate(const struct device *device, uint32_t bitrate);
int can_start(const struct device *device);
int can_add_rx_filter_msgq(const struct device *device, struct k_msgq *queue, const struct can_filter *filter);
int can_send(const struct device *device, const struct can_frame *frame, k_timeout_t timeout,
             can_tx_callback_t callback, void *user);

#endif
