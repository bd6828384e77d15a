/* Declarations of Zephyr's functions, as far as the example calls them: https://docs.zephyrproject.org/apidoc/latest/ */

#ifndef ZEPHYR_KERNEL_H
#define ZEPHYR_KERNEL_H

#include <stdint.h>

typedef struct {
    int64_t ticks;
} k_timeout_t;

#define K_NO_WAIT ((k_timeout_t){0})
#define K_MSEC(ms) ((k_timeout_t){(ms)})

struct k_msgq {
    uint32_t size;
};

int k_msgq_get(struct k_msgq *queue, void *data, k_timeout_t timeout);
int32_t k_sleep(k_timeout_t timeout);
void printk(const char *format, ...);

#endif
