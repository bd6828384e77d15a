/* See kernel.h. */

#ifndef ZEPHYR_DEVICE_H
#define ZEPHYR_DEVICE_H

#include <stdbool.h>

struct device {
    const char *name;
};

extern const struct device zephyr_canbus_device;

#define DT_CHOSEN(name) name##_device
#define DEVICE_DT_GET(node) (&node)

bool device_is_ready(const struct device *device);

#endif
