/* Arguments from the emulator's command line. The C libraries' own starts take lines of 255 characters or none, and all
 * vectors by name are longer; a small machine makes LINE_SIZE smaller. */

#include "start.h"

#include <stdint.h>
#include <stdlib.h>

extern int main(int argc, char **argv);

#ifndef LINE_SIZE
#define LINE_SIZE 65536
#endif

enum { SYS_GET_CMDLINE = 0x15, ARGUMENTS_MAX = LINE_SIZE / 64 };

static char line[LINE_SIZE];
static char *arguments[ARGUMENTS_MAX + 1];

/* The command line cut at its spaces. */
static int split(char *rest)
{
    int count = 0;

    while (*rest != '\0' && count < ARGUMENTS_MAX) {
        arguments[count++] = rest;
        while (*rest != '\0' && *rest != ' ') {
            rest++;
        }
        while (*rest == ' ') {
            *rest++ = '\0';
        }
    }
    return count;
}

void run_program(void)
{
    struct {
        char *text;
        uint32_t size;
    } block = {line, sizeof line};

    if (semihosting(SYS_GET_CMDLINE, &block) != 0) {
        _Exit(71);
    }
    exit(main(split(line), arguments));
}
