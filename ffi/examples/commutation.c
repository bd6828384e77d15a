/* The commutation table alone, for a driver that knows its sector. It replaces a table such as:
 *
 *     static const uint8_t table[6] = {0x21, 0x24, 0x0C, 0x12, ...};      which bit was phase B low?
 */

#include <stdio.h>

#include "narx.h"

static const char *const names[3] = {"off", "low", "PWM"};

int main(void)
{
    uint8_t sector;
    uint8_t towards;
    int sum = 0;

    for (towards = 0; towards < 2; towards++) {
        puts(towards == 0 ? "forward     A    B    C" : "reverse     A    B    C");
        for (sector = 0; sector < 6; sector++) {
            narx_step_t step;
            uint8_t legs[3];

            if (narx_commutation_step_for(sector, towards, &step) != NARX_OK || narx_commutation_legs(step, legs) != NARX_OK) {
                return 1;
            }
            printf("sector %u  %s  %s  %s\n", (unsigned)sector, names[legs[0]], names[legs[1]], names[legs[2]]);
            /* One leg is switched, one is low, one is off; the other direction exchanges the first two. */
            sum += legs[0] != legs[1] && legs[1] != legs[2] && legs[2] != legs[0];
        }
    }
    return sum == 12 ? 0 : 1;
}
