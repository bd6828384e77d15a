/* The drive of examples/drive.c. */

#ifndef DRIVE_H
#define DRIVE_H

#include "narx.h"

narx_status_t drive_init(const narx_board_t *board, const narx_stored_t *stored, size_t count);
void drive_interrupt(void);
void drive_loop(void);

#endif
