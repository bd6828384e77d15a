/* The messages alone, for a board that only communicates: a set-point for a drive, and a frame from the
 * drive. */

#include <stdio.h>
#include <string.h>

#include "narx.h"

int main(void)
{
    narx_message_t message;
    narx_frame_t frame;

    memset(&message, 0, sizeof message);
    message.kind = NARX_MESSAGE_MOTOR_CMD_SET;
    message.drive = 170;
    message.master = 85;
    message.fields.motor_cmd_set.speed = 2000;
    if (narx_message_encode(&message, &frame) != NARX_OK) {
        return 1;
    }
    printf("%08lX %u bytes: %02X %02X ...\n", (unsigned long)frame.id, (unsigned)frame.length, frame.data[0], frame.data[1]);

    /* MEASUREMENT_2 as a drive sends it. */
    frame.id = 0x1552A8CAu;
    memcpy(frame.data, "\x09\x60\x01\xF4\x17\x70\x36\xB0", 8);
    if (narx_message_decode(&frame, &message) != NARX_OK || message.kind != NARX_MESSAGE_MEASUREMENT_2) {
        return 1;
    }
    printf("bus %ld mV, %ld mA\n", 10L * message.fields.measurement_2.hv_voltage, (long)message.fields.measurement_2.hv_current);
    return message.fields.measurement_2.hv_voltage == 2400 && message.fields.measurement_2.hv_current == 500 ? 0 : 1;
}
