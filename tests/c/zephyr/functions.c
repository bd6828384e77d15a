/* Functions of Zephyr that do nothing, so that the example links. */

#include <zephyr/drivers/can.h>
#include <zephyr/irq.h>

const struct device zephyr_canbus_device;

int k_msgq_get(struct k_msgq *queue, void *data, k_timeout_t timeout)
{
    (void)queue, (void)data, (void)timeout;
    return -1;
}

int32_t k_sleep(k_timeout_t timeout)
{
    (void)timeout;
    return 0;
}

void printk(const char *format, ...)
{
    (void)format;
}

bool device_is_ready(const struct device *device)
{
    (void)device;
    return true;
}

void connected(unsigned irq, unsigned priority, int (*handler)(void), unsigned flags)
{
    (void)irq, (void)priority, (void)flags;
    (void)handler();
}

void irq_enable(unsigned irq)
{
    (void)irq;
}

int can_set_bitrate(const struct device *device, uint32_t bitrate)
{
    (void)device, (void)bitrate;
    return 0;
}

int can_start(const struct device *device)
{
    (void)device;
    return 0;
}

int can_add_rx_filter_msgq(const struct device *device, struct k_msgq *queue, const struct can_filter *filter)
{
    (void)device, (void)queue, (void)filter;
    return 0;
}

int can_send(const struct device *device, const struct can_frame *frame, k_timeout_t timeout,
             can_tx_callback_t callback, void *user)
{
    (void)device, (void)frame, (void)timeout, (void)callback, (void)user;
    return 0;
}
