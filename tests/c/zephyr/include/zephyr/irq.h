/* See kernel.h. */

#ifndef ZEPHYR_IRQ_H
#define ZEPHYR_IRQ_H

#define IRQ_ZERO_LATENCY 1

void connected(unsigned irq, unsigned priority, int (*handler)(void), unsigned flags);
void irq_enable(unsigned irq);

#define ISR_DIRECT_DECLARE(name) static int name(void)
#define IRQ_DIRECT_CONNECT(irq, priority, handler, flags) connected(irq, priority, handler, flags)

#endif
