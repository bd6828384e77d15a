#include <narx.h>

#include <stdio.h>

static narx_drive_t drive;

int main(void)
{
    const narx_status_t status = narx_drive_init(&drive, sizeof drive, NULL);

    printf("narx %s: %s\n", narx_version(), narx_status_text(status));
    return status == NARX_OK ? 0 : 1;
}
