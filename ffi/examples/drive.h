/* The drive of examples/drive.c. */

#ifndef DRIVE_H
#define DRIVE_H

#include "narx.h"

narx_status_t drive_init(const narx_board_t *board);
narx_status_t drive_set(uint16_t number, int32_t value);
void drive_interrupt(void);
void drive_loop(void);

#endif
