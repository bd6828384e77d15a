/* Checks of a test program: each is counted, and one that fails is told with its line. */

#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>
#include <stdlib.h>

static int passed;
static int failed;

static inline void check(int good, const char *file, int line, const char *what)
{
    if (good) {
        passed++;
    } else {
        failed++;
        printf("%s:%d: not so: %s\n", file, line, what);
    }
}

#define CHECK(condition) check((condition) ? 1 : 0, __FILE__, __LINE__, #condition)

/* In a loop of thousands: counted where it fails. */
#define CHECK_QUIETLY(condition) \
    do { \
        if (!(condition)) { \
            CHECK(condition); \
        } \
    } while (0)

/* The closing line, and the exit code. */
static inline int report_checks(void)
{
    printf("%d passed, %d failed\n", passed, failed);
    return failed == 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}

#endif
